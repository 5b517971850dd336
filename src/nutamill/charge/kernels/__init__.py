"""The compiled loops of the charge."""
