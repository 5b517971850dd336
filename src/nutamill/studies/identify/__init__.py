"""Identification: values of unknown numbers that agree with what was measured, and what follows."""
