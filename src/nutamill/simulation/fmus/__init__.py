"""Models of other programs (FMI) in a run: description, mapping, process, exchange."""
