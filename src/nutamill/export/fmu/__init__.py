"""A machine as an FMU: its interface, its description, its library for each platform, its archive."""
