"""What the particles are: shapes, sizes, numbers; plain NumPy."""
