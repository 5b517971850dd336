"""Multibody engine."""
