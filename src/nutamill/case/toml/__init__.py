"""Case files: layers, positions of faults, messages, schema."""
