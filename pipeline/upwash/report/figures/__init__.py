"""The figures, one module each: `draw` makes one from results folders."""

from upwash.report.figures.catalogue import FIGURES, draw

__all__ = ["FIGURES", "draw"]
