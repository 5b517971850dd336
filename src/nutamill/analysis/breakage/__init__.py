"""What the impacts of a run do to ore: laws of single particles, layers between balls, population balance."""
