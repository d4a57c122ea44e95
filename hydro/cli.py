"""The command line. Heavy imports wait until a command needs them, so that --help answers at once."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from hydro.errors import DeckError, HydroError, Missed, RunFailed, Stopped

USAGE = """\
python -m hydro DECK.toml [section.key=value ...] [--output DIR] [--quiet] [--overwrite] [--scheduler ADDRESS]
       python -m hydro restart RUNDIR [section.key=value ...] [--quiet]
       python -m hydro movie RUNDIR [key=value ...] [--quiet]
       python -m hydro check DECK.toml [section.key=value ...]
       python -m hydro compare RUNDIR STEADY [--quiet]
       python -m hydro overlay RUNDIR [RUNDIR ...] [--output DIR] [--movie] [--quiet]
       python -m hydro report RUNDIR [--quiet]
       python -m hydro verify [--full]"""

EPILOG = """\
A run writes output/<deck name>/ unless --output names another folder: the resolved deck, summary.json,
checkpoints, pictures, tables. Exit codes: 0 done; 2 bad deck or arguments; 3 it failed, what was good is saved;
4 stopped by a signal or a time limit, what was finished is saved; 5 a claim of the verification book fails, or what
a study expects."""

MOVIE_EPILOG = """\
The keys say how the movie looks: colours (gray, viridis, cividis, magma, inferno), scale (linear, log), limits
(frame, run), traces (true, false), frames_per_second, gif (true, false). See docs/looking.md."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # sparse factors are small products, for which threads only wait
    words = list(sys.argv[1:] if arguments is None else arguments)
    command = COMMANDS[words.pop(0)] if words and words[0] in COMMANDS else run
    try:
        with interruptible():
            return command(words)
    except HydroError as error:
        print(f"hydro: {error}", file=sys.stderr)
        return error.exit_code
    except (MemoryError, OSError) as error:
        print(f"hydro: {error or 'not enough memory'}", file=sys.stderr)
        return RunFailed.exit_code
    except KeyboardInterrupt:
        print("hydro: stopped by a signal before the first result or after the last", file=sys.stderr)
        return Stopped.exit_code


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Within it SIGTERM interrupts as Ctrl-C does, and SIGUSR1 does nothing, until a run takes care of them."""
    handlers: dict[int, Any] = {signal.SIGTERM: signal.default_int_handler, signal.SIGUSR1: signal.SIG_IGN}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def run(words: list[str]) -> int:
    """Run a deck of any kind."""
    parser = _parser("Run a problem deck.", EPILOG)
    parser.add_argument("--output", type=Path, metavar="DIR", help="folder of the run")
    parser.add_argument("--quiet", action="store_true", help="no progress, no closing lines")
    parser.add_argument("--overwrite", action="store_true", help="replace a run that the folder holds")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, to run the members of a sweep on")
    options = parser.parse_intermixed_args(words)

    from hydro.deck import load
    from hydro.output.folder import RunFolder

    deck = load(options.deck, options.overrides)
    folder = RunFolder(options.output or Path("output") / options.deck.stem)

    from hydro.choices import KINDS
    from hydro.kinds.run import run_in

    if options.scheduler and deck.kind != "sweep":
        raise DeckError(f"only a sweep runs on a cluster, not a deck of kind {deck.kind!r}", "--scheduler")
    where = {"scheduler": options.scheduler} if options.scheduler else {}
    summary = run_in(folder, deck, options.overwrite, options.quiet, **where)
    return _close(KINDS[deck.kind], summary, folder, options.quiet)


def restart(words: list[str]) -> int:
    """Go on with a run that was stopped or killed, or take a finished one further."""
    description = "Go on with a run from its newest checkpoint, to the same bits as if it had not been interrupted."
    parser = _parser(description, None, "folder", "RUNDIR", "folder of the run")
    parser.add_argument("--quiet", action="store_true", help="no progress, no closing lines")
    options = parser.parse_intermixed_args(words)

    from hydro.choices import KINDS
    from hydro.driver.restart import deck_of
    from hydro.output.folder import RunFolder

    folder = RunFolder(options.folder)
    if not folder.path.is_dir():
        raise DeckError(f"{folder.path} is not the folder of a run", "restart")
    with folder.held():
        deck = deck_of(folder, options.overrides)
        kind = KINDS[deck.kind]
        if kind.resume is None:
            raise DeckError(f"a run of kind {deck.kind!r} cannot be continued; run its deck anew", "restart")
        if kind.goes_on:
            folder.check(False, deck)  # a changed study would lose its members
        summary = kind.resume(deck, folder, options.quiet)
    return _close(kind, summary, folder, options.quiet)


def _close(kind: Any, summary: dict[str, Any], folder: Any, quiet: bool) -> int:
    """Say what came out; Missed if that is not what the deck expects."""
    if not quiet:
        print("\n".join([*kind.closing(summary), f"results in {folder.path}"]))
    if summary.get("missed"):
        raise Missed("not as expected\n  " + "\n  ".join(summary["missed"]))
    return 0


def movie(words: list[str]) -> int:
    """Make the movie of an evolution, at its end or while it goes on."""
    parser = argparse.ArgumentParser(
        "python -m hydro movie", description="Make movie.mp4 and movie.gif of an evolution.", epilog=MOVIE_EPILOG
    )
    parser.add_argument("folder", type=Path, metavar="RUNDIR", help="folder of the run")
    parser.add_argument("keys", nargs="*", default=[], metavar="key=value", help="keys of the section [movie]")
    parser.add_argument("--quiet", action="store_true", help="no progress, no closing lines")
    options = parser.parse_intermixed_args(words)

    from hydro.output.folder import RunFolder

    folder = RunFolder(options.folder)
    deck = folder.load_deck([f"movie.{word.removeprefix('movie.')}" for word in options.keys])

    from hydro.movies.movie import make_movie

    made = make_movie(deck, folder, options.quiet)
    if not options.quiet:
        print("\n".join(map(str, made)))
    return 0


def check(words: list[str]) -> int:
    """Print the resolved deck, its scales and its warnings; run nothing."""
    parser = _parser("Parse and validate a deck; print it resolved, with its physical scales and warnings.", None)
    options = parser.parse_intermixed_args(words)

    from hydro.deck import dumps, load

    deck = load(options.deck, options.overrides)

    from hydro.choices import KINDS

    print(dumps(deck))
    print("\n".join(f"# {line}" for line in KINDS[deck.kind].describe(deck)))
    return 0


def compare(words: list[str]) -> int:
    """Compare a run with a steady state, write that into its folder, and print it."""
    parser = argparse.ArgumentParser("python -m hydro compare", description="Compare a run with a steady state.")
    parser.add_argument("run", type=Path, metavar="RUNDIR", help="folder of an evolution run")
    parser.add_argument(
        "steady", metavar="STEADY", help="folder of a steady run, or 'auto' to solve for the nearest state"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress, no tables")
    options = parser.parse_args(words)

    from hydro.compare import comparison

    result = comparison.compare(options.run, options.steady, options.quiet)
    if not options.quiet:
        print("\n".join([*comparison.closing(result), f"results in {options.run / 'compare'}"]))
    return 0


def overlay(words: list[str]) -> int:
    """Lay runs over each other, and print how they end."""
    description = "Draw the histories of runs over each other, and their last densities side by side."
    parser = argparse.ArgumentParser("python -m hydro overlay", description=description)
    parser.add_argument("runs", type=Path, nargs="+", metavar="RUNDIR", help="folders of evolutions or runs of grains")
    parser.add_argument("--output", type=Path, default=Path("output/overlay"), metavar="DIR", help="folder of results")
    parser.add_argument("--movie", action="store_true", help="make a movie of the densities side by side, too")
    parser.add_argument("--quiet", action="store_true", help="no progress, no table")
    options = parser.parse_args(words)

    from hydro.compare import overlay

    result = overlay.overlay(options.runs, options.output, options.movie, options.quiet)
    if not options.quiet:
        print("\n".join([*overlay.closing(result), f"results in {options.output}"]))
    return 0


def report(words: list[str]) -> int:
    """Write the page of a run."""
    parser = argparse.ArgumentParser("python -m hydro report", description="Write one HTML page on a run of any kind.")
    parser.add_argument("run", type=Path, metavar="RUNDIR", help="folder of the run")
    parser.add_argument("--quiet", action="store_true", help="do not say where it is")
    options = parser.parse_args(words)

    from hydro.report.page import write_report

    page = write_report(options.run)
    if not options.quiet:
        print(f"report in {page}")
    return 0


def verify(words: list[str]) -> int:
    """Measure every claim of the verification book and print it."""
    parser = argparse.ArgumentParser("python -m hydro verify", description="Print the verification book.")
    parser.add_argument("--full", action="store_true", help="finer grids, more combinations")
    full = parser.parse_args(words).full

    from hydro.verification.book import write

    return write(full)


COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "restart": restart,
    "check": check,
    "movie": movie,
    "compare": compare,
    "overlay": overlay,
    "report": report,
    "verify": verify,
}


def _parser(
    description: str, epilog: str | None, name: str = "deck", metavar: str = "DECK.toml", meaning: str = "problem deck"
) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m hydro", USAGE, description, epilog, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(name, type=Path, metavar=metavar, help=meaning)
    parser.add_argument(
        "overrides", nargs="*", default=[], metavar="section.key=value", help="keys to override in the deck"
    )
    return parser
