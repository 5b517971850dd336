"""Width of the vector law."""

BATCH = 32
"""Contacts that one pass of the vector law takes [1]."""
