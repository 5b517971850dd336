"""Walls of exact shapes and of closed meshes."""
