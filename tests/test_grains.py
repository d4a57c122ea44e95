"""The grains: event-driven dynamics against conservation, kinetic theory, and itself in other ways."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest

from hydro.errors import RunFailed
from hydro.gas import Grossman
from hydro.grains import books, cells, prediction, theory
from hydro.grains.cells import arena
from hydro.grains.clusters import LINK, clusters
from hydro.grains.dynamics import EPOCH, Dynamics
from hydro.grains.placement import CLOSE_PACKING, lattice, placed
from hydro.grains.queue import (
    FINEST,
    NOBODY,
    calendar,
    cancel,
    day_of,
    earliest_today,
    keep_pace,
    schedule,
    schedule_all,
    tomorrow,
)
from hydro.grains.random import seeded
from hydro.grains.state import MOTION, PROSPECT
from hydro.grains.walls import ElasticWall, RandomPhaseWall, SawtoothWall, SinusoidalWall, ThermalWall
from hydro.jit import kernel
from hydro.mesh import Mesh
from hydro.state import State

PERIODIC = (True, True)
WALLS = {
    "elastic": ElasticWall(),
    "thermal": ThermalWall(2.0),
    "random-phase": RandomPhaseWall(0.3),
    "sinusoidal": SinusoidalWall(0.01, 30.0, 2.0 * math.pi / 30.0),
    "sawtooth": SawtoothWall(0.01, 0.1),
}


def gas_of_grains(number, n, wall=WALLS["elastic"], restitution=1.0, periodic=(False, False), length_y=1.0, **options):
    """Grains of a uniform density and temperature 1."""
    diameter = math.sqrt(CLOSE_PACKING * n * length_y / number)
    state = State.of(Grossman(L=0.0, K=1.0), Mesh.rectangle((4, 4), length_y, periodic=periodic), n, 1.0)
    positions, velocities = placed(state, number, diameter, seed=1)
    box = arena(diameter, restitution, length_y, periodic)
    return Dynamics(box, wall, positions, velocities, seed=2, **options)


def same(first, second, *names):
    """Whether entries of two memories are the same to the bit."""
    return all(np.array_equal(first[name], second[name]) for name in names)


def test_elastic_grains_keep_their_energy_and_do_not_overlap():
    gas = gas_of_grains(400, 0.5)
    start = gas.energy
    for stop in range(1, 21):
        gas.advance(0.25 * stop)
        assert gas.smallest_gap > -1e-12
    assert gas.count(books.COLLISIONS) > 50_000
    assert abs(gas.energy / start - 1.0) < 1e-12
    assert np.all((gas.positions > -1e-12) & (gas.positions < 1.0 + 1e-12))


def test_grains_do_not_overlap_in_ten_million_collisions():
    """Seen right after every 10,000th event: grains that have just collided touch."""
    gas, smallest = gas_of_grains(1000, 0.5, WALLS["thermal"], 0.95), math.inf
    while gas.count(books.COLLISIONS) < 10_000_000:
        smallest = min(smallest, gas.closest_until(gas.time + EPOCH, 10_000))
    assert -1e-12 < smallest < 1e-6


def test_momentum_is_kept_in_a_periodic_box():
    gas = gas_of_grains(400, 0.3, restitution=0.95, periodic=PERIODIC, length_y=2.0)
    start = gas.velocities.sum(axis=0)
    gas.advance(2.0)
    assert gas.count(books.COLLISIONS) > 5_000 and gas.smallest_gap > -1e-12
    assert np.abs(gas.velocities.sum(axis=0) - start).max() < 1e-11


@kernel(exact=True)
def play(queue, times, after, others, waits, until):
    """Events up to a time; returns how many. Event k comes again after[k] later; that of others[k], waits[k] later."""
    schedule_all(queue, 0.0)
    now, k = 0.0, 0
    while k < after.size:
        keep_pace(queue, now)
        i = earliest_today(queue)
        if i == NOBODY:
            if queue.today[0] >= day_of(queue, until):
                break
            tomorrow(queue)
            continue
        now = queue.entries[i].event
        if now > until:
            break
        times[k] = now
        cancel(queue, i)
        schedule(queue, i, now + after[k])
        cancel(queue, others[k])
        schedule(queue, others[k], now + waits[k])
        queue.since[0] += 1
        k += 1
    return k


@pytest.mark.parametrize("pace", [1e-3, 1.0, FINEST])
@pytest.mark.parametrize("number", [1, 2, 7, 300])
def test_the_calendar_gives_events_in_their_order(number, pace):
    """However slow or fast its days are at first, while the rate of events rises and falls by orders of magnitude."""
    random = np.random.default_rng(number)
    size = 20 * number + 1000
    scale = 10.0 ** (-3.0 - 2.5 * np.sin(np.linspace(0.0, 12.0, size)))
    after, waits = (scale * random.exponential(size=size) for _ in range(2))
    after[random.random(size) < 0.01] = 0.0
    after[random.random(size) < 0.02] *= -0.1  # round-off puts events just before now, be it on another day
    others, until = random.integers(number, size=size), 0.5
    waits[(others == 0) & (others < number - 1) & (random.random(size) < 0.1)] = math.inf
    entries = np.zeros(number, PROSPECT)
    entries["event"] = foreseen = random.exponential(size=number) * 1e-3
    queue = calendar(entries, pace)
    times = np.zeros(size)
    happened = play(queue, times, after, others, waits, until)
    expected, foreseen = [], foreseen.copy()
    for k in range(size):
        i = foreseen.argmin()
        if foreseen[i] > until:
            break
        expected.append(foreseen[i])
        foreseen[i] = expected[-1] + after[k]
        foreseen[others[k]] = expected[-1] + waits[k]
    assert happened == len(expected) > 100
    assert np.array_equal(times[:happened], expected) and np.array_equal(entries["event"], foreseen)


def test_an_event_that_waits_for_its_page_is_not_missed_when_no_other_comes():
    """Grain 0 has events on days 0 and 100, grain 2 on day 150; those of all others never come."""
    entries = np.zeros(300, PROSPECT)
    entries["event"] = math.inf
    entries["event"][[0, 2]] = 0.5, 150.5
    times, never = np.zeros(3), np.full(3, math.inf)
    after = np.array([100.0, math.inf, math.inf])
    assert play(calendar(entries, 1.0), times, after, np.ones(3, np.int64), never, 1000.0) == 3
    assert times.tolist() == [0.5, 100.5, 150.5]


@pytest.mark.parametrize("pace", [1.0, FINEST])
def test_days_come_to_hold_one_event_or_two(pace):
    """Whatever their length was; the grains begin on a dense lattice, where next events come much sooner than later."""
    gas = gas_of_grains(1000, 0.9)
    queue = gas.grains.queue
    queue.pace[0] = pace
    schedule_all(queue, 0.0)
    gas.advance(0.1)
    soon = gas.grains.prospects["event"] * queue.pace[0] - queue.today[0]
    assert 0.2 * 100.0 < np.count_nonzero(soon < 100.0) < 5.0 * 100.0


def test_grains_at_rest_let_time_pass():
    """No event ever: the calendar must not wait for one."""
    gas = Dynamics(arena(0.1, 1.0, 1.0), ElasticWall(), np.array([[0.2, 0.5], [0.7, 0.5]]), np.zeros((2, 2)))
    gas.advance(5.0)
    assert gas.time == 5.0 and gas.count(books.COLLISIONS) == 0


@pytest.mark.parametrize("periodic", [PERIODIC, (True, False)])
def test_cells_of_a_periodic_box_do_not_change_the_sequence_of_events(periodic):
    """Three cells across, which is the least, more, and their own."""
    options = dict(restitution=0.97, periodic=periodic, length_y=1.3)
    runs = [gas_of_grains(60, 0.3, cell=cell, **options) for cell in (0.5, 0.12, None)]
    assert [run.arena.columns for run in runs[:2]] == [3, 8]
    for run in runs:
        run.advance(2.0)
    assert runs[0].count(books.COLLISIONS) > 500
    widest, *others = (run.memory() for run in runs)
    assert all(same(widest, other, "motion", "sums") for other in others)


def test_places_lie_in_the_box():
    """Also of grains that round-off has put just outside."""
    positions = np.array([[-1e-18, 0.5], [0.5, -1e-19], [1.0 + 1e-9, 2.0 + 1e-9]])
    gas = Dynamics(arena(0.1, 1.0, 2.0, PERIODIC), WALLS["elastic"], positions, np.zeros_like(positions))
    assert gas.places == pytest.approx(np.array([[0.0, 0.5], [0.5, 0.0], [1e-9, 1e-9]]), abs=1e-12)
    assert np.all((gas.places >= 0.0) & (gas.places < [1.0, 2.0])) and clusters(gas).tolist() == [0, 1, 2]


@pytest.mark.parametrize("name", WALLS)
def test_cells_do_not_change_the_sequence_of_events(name):
    """All pairs, cells of two sizes, and of their own, to the bit: dozens of collisions each magnify any difference."""
    runs = [gas_of_grains(60, 0.3, WALLS[name], 0.99, cell=cell) for cell in (1.0, 0.12, 0.31, None)]
    assert [run.arena.columns for run in runs[:3]] == [1, 8, 3]
    for run in runs:
        run.advance(2.0)
    assert runs[0].count(books.COLLISIONS) > 1_000
    all_pairs, *others = (run.memory() for run in runs)
    assert all(same(all_pairs, other, "motion", "random", "sums") for other in others)


@pytest.mark.parametrize("reach", [0.0, 0.3])
@pytest.mark.parametrize("periodic", [(False, False), PERIODIC], ids=["walls", "periodic"])
def test_cells_are_narrow_where_grains_are_crowded(periodic, reach):
    """As wide as a grain at least, and the last one as wide as a wall may reach; every place is in its cell."""
    random = np.random.default_rng(4)
    corner, thin = random.uniform(0.0, 0.15, (4000, 2)), random.uniform(0.0, 1.0, (500, 2)) * [1.0, 2.0]
    places = np.concatenate([corner, thin])
    box = cells.crowded(arena(0.002, 1.0, 2.0, periodic), places, reach)
    widths_x, widths_y = np.diff(box.borders_x), np.diff(box.borders_y)
    assert min(widths_x.min(), widths_y.min()) >= cells.NARROWEST * 0.002 and widths_x[-1] >= reach
    assert (box.borders_x[0], box.borders_x[-1], box.borders_y[0], box.borders_y[-1]) == (0.0, 1.0, 0.0, 2.0)
    assert widths_x[-2] > 3.0 * widths_x[0] and widths_y[-1] > 3.0 * widths_y[0]
    column, row = cells.inside(box, places).T
    assert np.all((box.borders_x[column] <= places[:, 0]) & (places[:, 0] <= box.borders_x[column + 1]))
    assert np.all((box.borders_y[row] <= places[:, 1]) & (places[:, 1] <= box.borders_y[row + 1]))
    assert 0.1 < len(corner) / np.unique(np.stack([column, row])[:, :4000], axis=1).shape[1] < 2.0


@pytest.mark.parametrize("number", [2, 30])
def test_a_small_periodic_box_has_three_cells_or_more(number):
    """Though its grains would be content with one."""
    box = cells.crowded(arena(0.3, 1.0, 1.0, PERIODIC), np.full((number, 2), 0.5))
    assert (box.columns, box.rows) == (3, 3)
    with pytest.raises(ValueError, match="three cells wide"):
        arena(0.4, 1.0, 1.0, PERIODIC)


@pytest.mark.parametrize("periodic", [(False, False), (False, True)], ids=["walls", "periodic"])
@pytest.mark.parametrize("name", WALLS)
def test_looking_and_restarting_change_nothing(name, periodic):
    straight, watched, resumed = (gas_of_grains(100, 0.3, WALLS[name], 0.95, periodic) for _ in range(3))
    straight.advance(1.3)
    for stop in (0.1, 0.25, 0.333, 0.7):
        watched.advance(stop)
    resumed.remember(watched.memory())
    resumed.advance(1.3)
    first, second = straight.memory(), resumed.memory()
    assert same(first, second, "motion", "epoch", "clock", "random", "sums", "time")
    assert straight.count(books.COLLISIONS) == resumed.count(books.COLLISIONS)


def test_memory_of_a_run_is_at_most_300_bytes_a_grain():
    """While grains are arranged anew too, and with the copy to which a collapse goes back."""
    grains = gas_of_grains(30_000, 0.3)
    tracemalloc.start()
    try:
        grains.remember(grains.memory())
        kept = grains.memory()
        tracemalloc.reset_peak()
        grains.advance(EPOCH)
        held, peak = (size / grains.number for size in tracemalloc.get_traced_memory())
    finally:
        tracemalloc.stop()
    assert len(kept["motion"]) == grains.number and 150.0 < held < 220.0 and peak < 300.0


def test_a_grazing_contact_is_foreseen_from_afar():
    """From 100 diameters, with all but 2e-13 of a diameter to the side: it touches, and at the right time."""
    diameter, distance = 0.001, 0.1
    aside = diameter * (1.0 - 2e-13)
    for angle in np.random.default_rng(6).uniform(0.0, 2.0 * math.pi, 200):
        along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        motion = np.zeros(2, MOTION)
        motion["x"], motion["y"] = np.stack([np.zeros(2), distance * along + aside * across]).T
        motion["vx"][1], motion["vy"][1] = -along
        assert prediction.collision_time(motion, 0, 1, 0.0, 0.0, diameter) == pytest.approx(distance, abs=1e-8)


@pytest.mark.parametrize("name", WALLS)
def test_the_books_balance(name):
    gas = gas_of_grains(200, 0.2, WALLS[name], 0.9)
    start = gas.energy
    gas.advance(3.0)
    gained, lost = gas.sum(books.WALL_ENERGY), gas.sum(books.LOSS)
    assert lost > 0.0 and (gained != 0.0) == (name != "elastic")
    assert gas.energy - start == pytest.approx(gained - lost, abs=1e-12 * (start + abs(gained) + lost))
    assert np.all(gas.positions[:, 0] < 1.01 + 1e-12) and gas.smallest_gap > -1e-12


@pytest.mark.parametrize("wall", [SinusoidalWall(0.2, 3.0, 2.0 * math.pi / 3.0), SawtoothWall(0.2, 1.0)])
def test_a_wall_that_reaches_far_is_not_passed(wall):
    """Grains meet it wherever it goes: farther than a cell of the usual width, a twentieth of the box."""
    gas = gas_of_grains(50, 0.1, wall, 0.9)
    assert 1.0 - gas.arena.borders_x[-2] > wall.amplitude
    for stop in range(1, 60):
        gas.advance(0.07 * stop)
        phase = gas.time % wall.period / wall.period
        sawtooth = isinstance(wall, SawtoothWall)
        place = 1.0 + wall.amplitude * (1.0 - 2.0 * phase if sawtooth else math.cos(2.0 * math.pi * phase))
        assert np.all(gas.positions[:, 0] < place + 1e-12)


def test_velocities_become_maxwellian():
    """Of grains that all start with the same speed; a Maxwellian in two dimensions has <v^4> = 2 <v^2>^2."""
    gas = gas_of_grains(1000, 0.3, periodic=PERIODIC)
    direction = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, gas.number)
    velocities = math.sqrt(2.0) * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    gas = Dynamics(gas.arena, gas.wall, gas.positions, velocities)
    seen = []
    for stop in range(60):
        gas.advance(1.0 + 0.1 * stop)
        squares = (gas.velocities**2).sum(axis=1)
        seen.append((squares**2).mean() / squares.mean() ** 2)
    assert np.mean(seen) == pytest.approx(2.0, rel=0.02)


def rates(gas, span):
    """(collisions of a grain in unit time, p/(n T)) over a time."""
    start, collisions, virial = gas.time, gas.count(books.COLLISIONS), gas.sum(books.VIRIAL)
    gas.advance(start + span)
    rate = 2.0 * (gas.count(books.COLLISIONS) - collisions) / (gas.number * span)
    return rate, 1.0 + (gas.sum(books.VIRIAL) - virial) / (2.0 * span * gas.energy)


def test_dilute_grains_collide_at_the_rate_of_enskog():
    """Some 100,000 collisions, hence 0.5 percent of noise at most."""
    gas = gas_of_grains(1000, 0.05, periodic=PERIODIC)
    gas.advance(1.0)
    rate, _ = rates(gas, 30.0)
    assert rate == pytest.approx(theory.collision_rate(0.05, 1.0, gas.arena.diameter), rel=0.02)


@pytest.mark.parametrize("n", [0.1, 0.3, 0.5, 0.7])
def test_pressure_is_that_of_henderson(n):
    gas = gas_of_grains(1000, n, periodic=PERIODIC)
    gas.advance(1.0)
    _, measured = rates(gas, 4.0)
    assert measured == pytest.approx(theory.compressibility(n), rel=0.02)


def test_pressure_on_walls_is_that_of_the_virial():
    """Centres of grains fill the box, so the force on a wall over its length is the pressure, to a few d."""
    gas = gas_of_grains(2000, 0.2)
    gas.advance(1.0)
    before, span = gas.grains.sums.copy(), 10.0
    _, virial = rates(gas, span)
    pushes = (gas.grains.sums - before)[[books.PUSH_LEFT, books.PUSH_RIGHT]] / span / gas.energy
    assert pushes == pytest.approx(virial, rel=0.05)


def test_grains_cool_as_haff_says():
    gas = gas_of_grains(2000, 0.1, restitution=0.98, periodic=PERIODIC)
    rate = theory.cooling_rate(0.1, 1.0, gas.arena.diameter, 0.98)
    for stop in (1.0, 2.0, 4.0):
        gas.advance(stop / rate)
        assert gas.energy / gas.number == pytest.approx((1.0 + 0.5 * stop) ** -2, rel=0.05)


def test_contact_time_ends_an_inelastic_collapse():
    """Five grains thrown at a wall in a row: at r = 0.1 they collide without end, unless contacts take time."""
    positions = np.stack([0.05 + 0.18 * np.arange(5), np.full(5, 0.5)], axis=1)
    velocities = np.stack([np.linspace(2.0, 0.1, 5), np.zeros(5)], axis=1)
    with pytest.raises(RunFailed, match="contact time"):
        Dynamics(arena(0.1, 0.1, 1.0), ElasticWall(), positions, velocities).advance(5.0)
    gas = Dynamics(arena(0.1, 0.1, 1.0, contact_time=1e-6), ElasticWall(), positions, velocities)
    gas.advance(5.0)
    assert gas.count(books.SOFT) > 0


def test_a_lone_grain_goes_from_wall_to_wall():
    gas = Dynamics(arena(0.1, 1.0, 2.0), ElasticWall(), np.array([[0.5, 1.5]]), np.array([[1.0, -0.75]]))
    gas.advance(7.3)
    folded = [np.abs((start + speed * 7.3 + length) % (2.0 * length) - length) for start, speed, length in
              ((0.5, 1.0, 1.0), (1.5, -0.75, 2.0))]  # fmt: skip
    assert gas.positions[0] == pytest.approx(folded, abs=1e-13)


@pytest.mark.parametrize("wall", [WALLS["sinusoidal"], WALLS["sawtooth"], SinusoidalWall(0.1, 20.0, math.pi / 10.0)])
def test_a_moving_wall_is_met_at_its_first_crossing(wall):
    """Against a fine scan of the gap; a grain must not pass through the wall, nor meet one that is not there."""
    random = np.random.default_rng(4)

    def place(time):
        phase = time % wall.period / wall.period
        if isinstance(wall, SawtoothWall):
            return 1.0 + wall.amplitude * (1.0 - 2.0 * phase)
        return 1.0 + wall.amplitude * np.cos(2.0 * np.pi * phase)

    met = 0
    for _ in range(300):
        start, v = random.uniform(0.0, wall.period), random.normal() * random.choice([0.02, 0.3, 1.0])
        x = place(start) - random.uniform(0.0, 3.0) * wall.amplitude
        after = wall.meeting(x, v, start)
        scan = np.linspace(0.0, min(after, 20.0 * wall.period), 20001)
        gaps = place(start + scan) - (x + v * scan)
        assert gaps[:-2].min() > -1e-3 * wall.amplitude
        if after < math.inf:
            met += 1
            assert abs(place(start + after * (1.0 - 1e-14)) - x - v * after) < 1e-9
            assert wall.rebound(v, 0.0, start + after, None)[0] < v
    assert met > 100


def contacts(wall, x, v, time, end):
    """Times at which a lone grain meets the wall before `end`."""
    times = []
    while (after := wall.meeting(x, v, time)) < end - time:
        x, time = x + v * after, time + after
        v = wall.rebound(v, 0.0, time, None)[0]
        times.append(time)
    return times


@pytest.mark.parametrize(("amplitude", "omega"), [(0.01, 30.0), (0.1, 20.0), (1e-3, 1e3), (0.2, 3.0)])
def test_grains_that_graze_a_sinusoidal_wall(amplitude, omega):
    """Flights that touch the wall, pass it by or cut into it by down to the last digit."""
    random, wall = np.random.default_rng(1), SinusoidalWall(amplitude, omega, 2.0 * math.pi / omega)
    met = 0
    for _ in range(2000):
        v = -amplitude * omega * random.uniform(-1.0, 1.0)
        phase = math.pi + math.asin(v / (amplitude * omega))  # where the wall is as fast, and the gap smallest
        deeper = 10.0 ** random.uniform(-17.0, -3.0) * random.choice([-1.0, 0.0, 1.0]) * amplitude
        before = random.uniform(0.0, 0.3) * wall.period
        x, time = 1.0 + amplitude * math.cos(phase) + deeper - v * before, phase / omega - before
        after = wall.meeting(x, v, time)
        flight = np.linspace(0.0, min(after, before + 0.2 * wall.period), 2001)
        gap = 1.0 + amplitude * np.cos(omega * (time + flight)) - (x + v * flight)
        if gap[0] > 0.0:
            assert gap[:-1].min() > -1e-12 * amplitude - 1e-15
            assert after == math.inf or abs(gap[-1]) < 1e-9 * amplitude or flight[-1] < after
            met += bool(flight[-1] == after)
    assert 500 < met < 1900


def test_grains_about_as_fast_as_a_sinusoidal_wall_meet_it_again_in_the_same_period():
    """One that catches up with a wall on its way out is met again as the wall comes back; then it leaves."""
    random, wall = np.random.default_rng(2), SinusoidalWall(0.01, 30.0, 2.0 * math.pi / 30.0)
    counts = []
    for _ in range(500):
        v, start = random.uniform(0.1, 0.6), random.uniform(0.0, wall.period)
        times = contacts(wall, 1.0 - wall.amplitude, v, start, start + 100.0 * wall.period)
        assert np.all(np.diff(times) > 0.0) and times[-1] - times[0] < wall.period
        counts.append(len(times))
    assert min(counts) == 1 and max(counts) > 2 and sum(count > 1 for count in counts) > 20


@kernel(exact=True)
def energies_after(wall, speeds, random):
    """Kinetic energies after grains of these normal velocities have met a wall at rest; replaces the speeds."""
    for k in range(speeds.size):
        speeds[k] = 0.5 * wall.rebound(speeds[k], 0.0, 0.0, random)[0] ** 2


def test_the_random_phase_gives_the_heat_of_the_paper():
    """q = (2/pi)^(1/2) A^2 omega^2 n T^(1/2): 2 (A omega)^2 for each of n (T/2 pi)^(1/2) impacts."""
    speed = 0.1
    incoming = np.sqrt(-2.0 * np.log(np.random.default_rng(6).random(1_000_000)))
    energies = incoming.copy()
    energies_after(RandomPhaseWall(speed), energies, seeded(5))
    gains = energies - 0.5 * incoming**2
    assert gains.std() / math.sqrt(gains.size) < 0.02 * 2.0 * speed**2
    assert gains.mean() == pytest.approx(2.0 * speed**2, rel=0.06)


def test_a_thermal_wall_gives_back_a_maxwellian_flux():
    """Energy T of the normal velocity on the average, and its spread: both 2, for T = 2."""
    energies = np.ones(1_000_000)
    energies_after(ThermalWall(2.0), energies, seeded(5))
    assert energies.mean() == pytest.approx(2.0, rel=0.01) and energies.std() == pytest.approx(2.0, rel=0.01)


def test_a_lattice_holds_close_packing():
    sites = lattice(0.01, 2.0)
    assert len(sites) > 0.97 * 2.0 * CLOSE_PACKING / 0.01**2
    assert np.all((sites > 0.0) & (sites < [1.0, 2.0]))


def test_grains_start_with_the_fields_of_the_deck():
    mesh = Mesh.rectangle((4, 4), 2.0)
    density = 0.1 + 0.05 * np.cos(np.pi * np.arange(4) / 3.0)[:, None] * np.ones(4)
    state = State.of(Grossman(L=0.0, K=1.0), mesh, density, 2.0, (0.3, 0.0))
    positions, velocities = placed(state, 20_000, math.sqrt(CLOSE_PACKING * state.mass / 20_000), seed=1)
    counts, *_ = np.histogram2d(*positions.T, bins=(mesh.x_faces, mesh.y_faces))
    expected = 20_000 * density * mesh.areas / state.mass
    assert np.abs(counts - expected).max() < 5.0 * np.sqrt(expected.max())
    assert velocities.mean(axis=0) == pytest.approx([0.3, 0.0], abs=1e-12)
    assert velocities.var(axis=0).mean() == pytest.approx(2.0, rel=1e-12)


def test_a_dense_gas_is_one_cluster_and_a_thin_one_many():
    """n = 0.4 and 0.6: the density at which friends of friends reach through the box lies between."""
    largest = {}
    for n in (0.4, 0.6):
        gas = gas_of_grains(4000, n)
        gas.advance(0.1)
        counts = np.bincount(clusters(gas))
        assert counts.sum() == gas.number and np.all(np.diff(counts) <= 0) and counts[-1] > 0
        largest[n] = counts[0] / gas.number
    assert largest[0.4] < 0.1 and largest[0.6] > 0.9


@pytest.mark.parametrize("periodic", [(False, False), (True, False), (False, True), PERIODIC])
def test_clusters_reach_across_periodic_borders(periodic):
    """A chain of three, the last beyond the border: its friend only where the box is periodic."""
    d, length_y = 0.02, 2.0
    step = 0.99 * LINK * d
    along = np.array([[0.5 * step, 1.0], [1.5 * step, 1.0], [1.0 - 0.5 * step, 1.0]])
    across = np.array([[0.5, 0.5 * step], [0.5, 1.5 * step], [0.5, length_y - 0.5 * step]])
    alone = np.array([[0.5, 1.0]])
    places = np.concatenate([alone, along, across])
    gas = Dynamics(arena(d, 1.0, length_y, periodic), WALLS["elastic"], places, np.zeros_like(places))
    sizes = [3 if periodic[0] else 2, 3 if periodic[1] else 2]
    cluster = clusters(gas)
    assert [np.count_nonzero(cluster == cluster[first]) for first in (1, 4)] == sizes
    assert np.count_nonzero(cluster == cluster[0]) == 1 and cluster[1] != cluster[4]
