"""What a bird saves at a given place: how it has to flap there to balance, what that costs, and what it may choose."""
