"""What is measured of a charge while it moves."""
