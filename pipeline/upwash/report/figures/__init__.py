"""The figures, one module each: `draw` makes one from results folders, `draw_all` writes all of them."""

from upwash.report.figures.catalogue import FIGURES, draw, draw_all

__all__ = ["FIGURES", "draw", "draw_all"]
