"""Grains against kinetic theory and hydrodynamics.

    python benchmarks/papers/grains_physics.py docs > docs/grains_physics.md
    python benchmarks/papers/grains_physics.py docs driving transport        # some parts

Draws into the folder. Each run is kept in output/grains_physics and not made again; remove what is to be measured anew.
All runs take some fifty minutes of one core.
"""

from __future__ import annotations

import sys
from pathlib import Path

from physics import driving, equation, extended, localized, transport

PARTS = {
    "driving": driving.section,
    "equation": equation.section,
    "transport": transport.section,
    "extended": extended.section,
    "localized": localized.section,
}

HEAD = """# Grains against theory and hydrodynamics

Printed by `python benchmarks/papers/grains_physics.py docs > docs/grains_physics.md` from runs that it keeps. `±` is a
standard error. Densities are in units of n_c, T is the mean of `v^2/2`, and the closures are those of the paper with
alpha = 1.15, gamma = 2.26. How the grains run is said in [grains.md](grains.md).
"""


def main(folder: Path, parts: list[str]) -> None:
    """Print the page, or some parts of it."""
    unknown = [name for name in parts if name not in PARTS]
    if unknown:
        raise SystemExit(f"no part {unknown[0]!r}; there are {', '.join(PARTS)}")
    print(HEAD)
    for name in parts or PARTS:
        print(PARTS[name](folder), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
