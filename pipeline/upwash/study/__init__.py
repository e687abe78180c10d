"""From frames of results to frames: what is compared of species, how sure it is, and what was observed."""
