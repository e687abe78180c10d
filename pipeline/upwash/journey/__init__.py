"""How fast and how far: lines followed while speed, mass or air change, the best speed, and a flight on its fuel."""
