"""The loops of the balance at a given place, compiled."""
