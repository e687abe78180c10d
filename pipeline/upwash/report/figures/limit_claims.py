"""Figure: what of the paper's claims survives where its equations are converged."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.paper.claim import FAILS, HOLDS, HOLDS_WITH_CONDITION, LIMIT_VERDICTS, MEANINGLESS
from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, dot, legend_below, letter, styled
from upwash.report.figures.picture import Picture

CAPTION = (
    "Each mark is one claim of the paper, topic by topic, at the same place in both panels: (a) judged in the "
    "paper's model, (b) judged in the limit by the same measure, for both laws of the follower's span. Grey: it "
    "has no meaning there, is about the paper's own text, or was not judged."
)
LOOKS: dict[str, dict[str, Any]] = {
    HOLDS: {"color": "#009E73", "marker": "o"},
    HOLDS_WITH_CONDITION: {"color": "#E69F00", "marker": "^"},
    FAILS: {"color": "#D55E00", "marker": "X"},
    MEANINGLESS: {"color": FAINT, "marker": "s", "markerfacecolor": "white"},
}
OTHER: dict[str, Any] = {"color": FAINT, "marker": "."}
JUDGED = {"verdict": "In the paper's model", "limit_verdict": "In the limit"}


def describe(claims: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for column, words in JUDGED.items():
        count = claims[column].value_counts()
        told = [f"{int(count[verdict])} {verdict}" for verdict in LIMIT_VERDICTS if verdict in count]
        parts.append(f"{words}: {', '.join(told)}")
    lost = claims[(claims["verdict"] == HOLDS) & (claims["limit_verdict"] == FAILS)]
    return f"{'. '.join(parts)}. {len(lost)} claims hold in the paper's model and fail in the limit."


@styled
def draw(claims: pd.DataFrame) -> Figure:
    """Draw one mark a claim, in the paper's model and in the limit."""
    claims = claims.reset_index(drop=True)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 3.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    topics = list(dict.fromkeys(claims["topic"]))
    for axes, (column, title), name in zip(panels, JUDGED.items(), "ab", strict=True):
        _draw_verdicts(axes, claims, column, topics)
        letter(axes, name, title)
    panels[0].set_yticks(range(len(topics)), topics)
    panels[0].set_ylim(len(topics) - 0.4, -0.6)
    marks = [dot(verdict, markersize=6, **look) for verdict, look in LOOKS.items()]
    legend_below(figure, [*marks, dot("other", markersize=6, **OTHER)], 5)
    return figure


def _draw_verdicts(axes: Axes, claims: pd.DataFrame, column: str, topics: list[str]) -> None:
    order = [*LOOKS, *(verdict for verdict in LIMIT_VERDICTS if verdict not in LOOKS)]
    ranks = claims.assign(**{name: claims[name].map(order.index) for name in JUDGED})
    claims = claims.loc[ranks.sort_values(list(JUDGED), kind="stable").index]
    for line, topic in enumerate(topics):
        for place, verdict in enumerate(claims.loc[claims["topic"] == topic, column]):
            look = LOOKS.get(verdict, OTHER)
            axes.plot(place + 1, line, linestyle="none", markersize=6, **look, gid=f"{column} {line} {place}")
    axes.set(xlabel="claims", xlim=(0.2, 1.0 + claims.groupby("topic").size().max()))
    axes.tick_params(axis="y", length=0)


PICTURE = Picture("limit-claims", "What survives of the paper's claims", CAPTION, describe, draw)
