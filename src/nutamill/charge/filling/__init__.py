"""Placing and settling of particles."""
