"""Riemann problems by both integrators, the table of docs/numerics.md: `python benchmarks/shocks.py`, two minutes."""

from __future__ import annotations

from hydro.verification.book import table_lines
from hydro.verification.implicit import hard_shocks

if __name__ == "__main__":
    for table in hard_shocks(True).tables:
        print("\n".join(table_lines(table)))
