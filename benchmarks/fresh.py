"""What has to be measured in a process of its own: `fresh.py memory N KIND` and `fresh.py start KIND BEGUN`."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

STATUS, PEAK_RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def memory(n: str, kind: str) -> dict[str, float]:
    """Peak resident bytes of one thread that steps on n x n cells, compilation left out."""
    import numba
    from cases import problem

    numba.set_num_threads(1)
    step_twice(*problem(32, kind))
    PEAK_RESET.write_text("5")
    step_twice(*problem(int(n), kind))
    return {"bytes": peak_bytes()}


def step_twice(state, integrator) -> None:
    """Two steps touch all the memory there is."""
    for _ in range(2):
        integrator.step(state, integrator.largest_step(state))


def peak_bytes() -> int:
    """VmHWM. (ru_maxrss will not do: it remembers the peak of the process that forked this one.)"""
    lines = STATUS.read_text().splitlines()
    return 1024 * int(next(line.split()[1] for line in lines if line.startswith("VmHWM")))


def start(kind: str, begun: str) -> dict[str, float]:
    """Seconds from `begun`, the time.time() when this process was started, to the import of hydro and to its
    first steps; then those to the first steps on another mesh."""
    import cases

    imported = time.time()
    step_twice(*cases.problem(32, kind))
    stepped = time.time()
    step_twice(*cases.problem(48, kind))
    again = time.time()
    return {"imported": imported - float(begun), "stepped": stepped - float(begun), "another": again - stepped}


if __name__ == "__main__":
    print(json.dumps({"memory": memory, "start": start}[sys.argv[1]](*sys.argv[2:])))
