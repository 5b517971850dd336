"""Multibody engine: rigid bodies, joints, loads and drives."""
