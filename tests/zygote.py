"""A process in which the kernels of small runs are loaded, and which forks children that run commands.

So a run starts in milliseconds, and can be killed at any moment of its life. Requests come as lines of JSON on standard
input: the words of a command and a file for its standard error, answered by the id of the child's process; or such an
id, answered, when that process has ended, by its exit code. Nothing is drawn: pictures take far longer than the runs.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import traceback

from numba.np.ufunc import parallel

from hydro.cli import main

DRAWN = (
    "hydro.pictures.density.density_panels", "hydro.pictures.profiles.profiles",
    "hydro.pictures.history.history_curves", "hydro.movies.movie.make_movie",
)  # fmt: skip


def draw_nothing(replace):
    """By `replace(name, function)`, let nothing take the place of all that draws an evolution."""
    for name in DRAWN:
        replace(name, lambda *_: None)


def fork(words, errors):
    """The id of a new process that runs a command."""
    if child := os.fork():
        return child
    code = 70
    parallel._backend_init_process_lock = None  # of all forks: one killed with it would stop the others
    try:
        with open(errors, "w", buffering=1) as sys.stderr:
            try:
                code = main(words)
            except BaseException:
                traceback.print_exc()
    finally:
        os._exit(code)


def serve(warm_up):
    from pytest import MonkeyPatch

    draw_nothing(MonkeyPatch().setattr)
    with tempfile.TemporaryDirectory() as folder:
        for number, words in enumerate(warm_up):
            main([*words, "--output", f"{folder}/{number}", "--quiet"])
    for line in sys.stdin:
        match json.loads(line):
            case [words, errors]:
                print(fork(words, errors), flush=True)
            case child:
                print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


if __name__ == "__main__":
    serve(json.loads(sys.stdin.readline()))
