"""Discrete-element engine."""
