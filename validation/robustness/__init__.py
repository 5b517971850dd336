"""Whether the program survives what users and attackers feed it: every input is used, or refused in words."""
