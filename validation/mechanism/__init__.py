"""The mechanism engine beside published benchmark problems and closed forms."""
