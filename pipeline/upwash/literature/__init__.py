"""What others measured, computed and derived, beside what both models say: the ledger of the literature."""
