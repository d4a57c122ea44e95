"""All benchmarks of speed, by one command: `python benchmarks/performance.py > docs/performance.md`.

About twenty minutes on two free cores. The parts can be run alone, see README.md in this folder.
"""

from __future__ import annotations

import explicit
import implicit
import steady
from pyro_client import default_environment


def main() -> None:
    """Print the page."""
    print("# Speed\n")
    print("Printed by `python benchmarks/performance.py > docs/performance.md`. Seconds are those of one machine, and")
    print("others may have used it at the same time: trust ratios more. How things are measured is said in")
    print("[benchmarks/README.md](../benchmarks/README.md).\n", flush=True)
    explicit.report(list(explicit.PARTS), explicit.FULL, default_environment().absolute())
    implicit.report(list(implicit.ALL))
    print()
    steady.report()


if __name__ == "__main__":
    main()
