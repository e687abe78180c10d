"""Species: what is known of each bird, how it is known, and the bird that the physics makes of it."""

from upwash.species.library import load_library, load_species, slug_of
from upwash.species.species import AMPLITUDE_CONVENTIONS, ImpossibleAmplitude, Species

__all__ = [
    "AMPLITUDE_CONVENTIONS",
    "ImpossibleAmplitude",
    "Species",
    "load_library",
    "load_species",
    "slug_of",
]
