"""Renew results/reference/observed.csv: what birds save where they were published to fly, by both models.

``make reference`` does it, after a change that is meant to change results. A figure of the page shows it.
"""

from __future__ import annotations

from upwash.study.observed.published_savings import KEPT, SPECIES, published_savings


def main() -> None:
    """Evaluate the published places, and keep what comes of it."""
    kept = published_savings(SPECIES).round(6)
    KEPT.write_text(kept.to_csv(index=False, lineterminator="\n"), encoding="utf-8")


if __name__ == "__main__":
    main()
