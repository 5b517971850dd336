"""From a case to numbers: the only room where "crank pin" becomes body, joint and load."""
