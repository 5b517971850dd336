"""Measured data: test files in, the same processing as of runs, and the two side by side."""
