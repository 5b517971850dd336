"""The charge in LAMMPS: its particles are marched there, on many processes, and its walls here."""
