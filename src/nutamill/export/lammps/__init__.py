"""Recorded charges as input of LAMMPS: the motion of the chamber, its walls, the script and its data."""
