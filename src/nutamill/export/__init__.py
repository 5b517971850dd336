"""Results in the words of other programs."""
