"""Machines and charges for other programs."""
