"""What a run is compared with: the run's states, and the steady state of its gas, box and mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydro.deck import EvolutionDeck, GrainsDeck, SteadyDeck
from hydro.errors import Complaint, DeckError
from hydro.output.checkpoint import averaged, read_checkpoint, readable_times
from hydro.output.folder import RunFolder
from hydro.progress import counted
from hydro.setup import gas_of, wall_of
from hydro.state import State
from hydro.steady.balance import Balance
from hydro.steady.localized import SteadyState
from hydro.steady.nearest import Attempt, candidates, carried, fits, nearest

AUTO = "auto"
SAME = 1e-6  # relative difference within which numbers of two decks, and masses, count as equal


@dataclass(frozen=True, eq=False)
class Subject:
    """The run that is compared: its deck, and its checkpoints in order of time."""

    deck: EvolutionDeck | GrainsDeck
    files: list[Path]

    @classmethod
    def of(cls, path: Path) -> Subject:
        """DeckError if the folder holds no evolution, nor grains, before a driving wall, or no checkpoints yet.

        Checkpoints that cannot be read are named on stderr and left out.
        """
        folder = RunFolder(path)
        deck = folder.load_deck()
        if not isinstance(deck, EvolutionDeck | GrainsDeck):
            problem = f"{path} holds a run of kind {deck.kind!r}; only an evolution or grains can be compared"
            raise DeckError(problem, "RUNDIR")
        refuse_idle(deck, folder)
        times = readable_times(folder.checkpoints)
        if not times:
            raise DeckError(f"{path} has no checkpoints yet", "RUNDIR")
        return cls(deck, list(times))

    @property
    def wall(self) -> Any:
        """The law of the driving wall."""
        return wall_of(self.deck)

    @property
    def states(self) -> Iterator[State]:
        """The states of all checkpoints, read one by one."""
        return map(self.state, self.files)

    def state(self, file: Path) -> State:
        """The state of a checkpoint; of grains, the average over the window before it."""
        saved = read_checkpoint(file)
        return State(gas_of(self.deck), saved.mesh, averaged(saved), saved.time)

    @property
    def last(self) -> State:
        """The state of the last checkpoint."""
        return self.state(self.files[-1])

    @property
    def balance(self) -> Balance:
        """The steady problem of the run's gas, wall, mesh and mass."""
        state = self.last
        return Balance.of(state.gas, self.wall, state.mesh, state.mass / state.mesh.aspect_ratio)


def refuse_idle(deck: EvolutionDeck | GrainsDeck, folder: RunFolder) -> None:
    """DeckError for a gas that has no steady state, naming the keys."""
    idle = {
        "wall.kind": deck.wall.kind == "elastic",
        "wall.W": getattr(deck.wall, "W", 1.0) == 0.0,
        "gas.K": deck.gas.K == 0.0,
        "gas.L": deck.gas.L == 0.0,
    }
    problem = "no steady state to compare with: heat must come from the wall and be lost in collisions"
    if any(idle.values()):
        raise DeckError([Complaint(key, problem) for key, holds in idle.items() if holds], str(folder.deck))


def steady_state_for(subject: Subject, steady: str, quiet: bool) -> tuple[SteadyState, list[Attempt]]:
    """The steady state of the folder `steady`, or that nearest to the run's last state ("auto") and what was tried."""
    if steady != AUTO:
        return state_of(Path(steady), subject), []
    state = subject.last
    waves = counted(candidates(state), "steady states", quiet)
    return nearest(subject.balance, state, waves)


def state_of(path: Path, subject: Subject) -> SteadyState:
    """The state of a steady run, on the run's mesh; DeckError if it is of another gas or box, or does not fit."""
    folder = RunFolder(path)
    if not folder.deck.is_file():
        raise DeckError(f"{path} is neither the folder of a steady run nor {AUTO!r}", "STEADY")
    deck = folder.load_deck()
    if not isinstance(deck, SteadyDeck):
        problem = f"{path} holds a run of kind {deck.kind!r}, not 'steady'; '{AUTO}' solves for a state"
        raise DeckError(problem, "STEADY")
    saved = read_checkpoint(folder.checkpoints / "steady.h5")
    balance, wave = subject.balance, deck.steady.wave
    refuse_other(subject, balance, deck)
    if not fits(wave, balance.mesh):
        periodic = " that are periodic" if balance.mesh.periodic[1] else ""
        problem = f"{path} has {wave} half-waves, which do not fit on the run's {balance.mesh.cells[1]} cells in y"
        raise DeckError(problem + periodic, "STEADY")
    return carried(balance, State(balance.gas, saved.mesh, saved.conserved), wave)


def refuse_other(subject: Subject, balance: Balance, deck: SteadyDeck) -> None:
    """DeckError if the densities of a steady deck are not those of the run's gas and box, naming the keys.

    They know nothing of K, tau, W or the temperature of a thermal wall: those are the run's.
    """
    run = subject.deck
    here, there = (gas_of(each, K=1.0)._asdict() for each in (run, deck))
    pairs = {
        **{f"gas.{name}": (here[name], there[name]) for name in here if name in there},
        "gas.closure": (run.gas.closure, deck.gas.closure),
        "gas.f": (balance.area_fraction, deck.gas.f),
        "box.aspect_ratio": (run.box.aspect_ratio, deck.box.aspect_ratio),
        "wall.kind": (run.wall.kind, deck.wall.kind),
    }
    complaints = [
        Complaint(key, f"{mine!r} in the run, {other!r} in the steady state", other)
        for key, (mine, other) in pairs.items()
        if not equal(mine, other)
    ]
    if complaints:
        raise DeckError(complaints, "not the same gas and box")


def equal(mine: Any, other: Any) -> bool:
    """Whether two texts are the same, or two numbers but for what masses of a run may be off."""
    return mine == other if isinstance(mine, str) else math.isclose(mine, other, rel_tol=SAME)
