"""How cases, check sheets, results and campaigns look in a notebook, and the progress of a run there."""
