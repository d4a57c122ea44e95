"""Decks: defaults, every complaint, overrides, the way back to TOML, and the reference."""

import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydro.choices import INITIAL_STATES, KINDS, PATTERNS, WALLS
from hydro.deck import EvolutionDeck, dumps, load, parse, validate
from hydro.deck.reference import reference
from hydro.errors import DeckError
from hydro.initial.checkpoint import FromCheckpoint
from hydro.initial.cosine import Cosine
from hydro.walls.elastic import Elastic
from hydro.walls.thermal import Thermal
from hydro.walls.vibrating import Vibrating

MINIMAL = """
kind = "evolution"
gas  = { L = 5e4, f = 0.0235, K = 2e-3, tau = 200.0 }
box  = { aspect_ratio = 2.0 }
mesh = { cells = [128, 256] }
wall = { kind = "vibrating", W = 114.0 }
initial = { kind = "cosine", amplitude = 0.1, wave = 2, temperature = 1.0 }
time = { end = 1290.0, integrator = "godunov" }
output = { times = [100.0, 500.0, 1000.0, 1290.0] }
"""
PROFILE = "initial={kind='profile', positions=[0, 1], density=[0.1, 0.2]%s}"
RIEMANN = "initial={kind='riemann', left=%s, right=[0.1, 0, 1]}"
MODES = "initial={kind='modes', waves=[1, 2], amplitudes=%s}"
CHECKPOINT = "initial={kind='checkpoint', path='a/b.h5', perturbation=%s}"


def complaints(*overrides, text=MINIMAL):
    """The complaints about a deck, by key."""
    with pytest.raises(DeckError) as caught:
        parse(text, overrides)
    return {complaint.key: complaint for complaint in caught.value.complaints}


def test_minimal_deck():
    deck = parse(MINIMAL)
    assert (deck.gas.L, deck.gas.f, deck.gas.tau, deck.gas.alpha) == (5e4, 0.0235, 200.0, 1.15)
    assert deck.mesh.cells == (128, 256)
    assert deck.wall == Vibrating(W=114.0)
    assert deck.initial == Cosine(amplitude=0.1, wave=2)
    assert deck.output_times == (100.0, 500.0, 1000.0, 1290.0)
    assert deck.history_interval == pytest.approx(2.58)
    with pytest.raises(ValueError, match="frozen"):
        deck.gas.L = 1.0


def test_defaults():
    deck = parse('kind="evolution"\ngas={L=0,f=0.1,K=0}\nmesh={cells=[4,4]}\ninitial={kind="uniform"}\ntime={end=2}')
    assert (deck.gas.tau, deck.wall.W, deck.time.cfl) == (math.inf, 114.0, 0.8)
    assert (deck.scheme.limiter, deck.scheme.riemann) == ("van_leer", "hllc_lm")
    assert deck.output_times == (2.0,)


@pytest.mark.parametrize(
    ("override", "key", "problem", "nearest"),
    [
        ("gas.f=1.5", "gas.f", "1.5 is not allowed; must be less than 1", None),
        ("gas.f=0", "gas.f", "must be greater than 0", None),
        ("gas.L=-1", "gas.L", "must be at least 0", None),
        ("gas.L='3'", "gas.L", "'3' is not allowed; must be a number", None),
        ("gas.L=true", "gas.L", "true is not allowed; must be a number", None),
        ("gas.L=2020-01-01", "gas.L", "must be a number", None),
        ("gas.L=1" + 400 * "0", "gas.L", "too large for a number", None),
        ("gas.L=0x" + 9000 * "f", "gas.L", "a huge number is not allowed; too large", None),
        ("gas.K=1e-31", "gas.K", "must be zero or of a size between 1e-30 and 1e+30", None),
        ("wall.W=1e31", "wall.W", "must be zero or of a size", None),
        ("gas.K=inf", "gas.K", "must be finite", None),
        ("gas.f=nan", "gas.f", "nan is not allowed", None),
        ("gas.tau=nan", "gas.tau", "nan is not allowed", None),
        ("gas.area_fracton=0.1", "gas.area_fracton", "unknown key; known: L, f, K, tau", "f"),
        ("gas.allpha=1", "gas.allpha", "unknown key", "alpha"),
        ("gas.W=1", "gas.W", "unknown key", "wall.W"),
        ("aspect_ratio=1", "aspect_ratio", "unknown key", "box.aspect_ratio"),
        ("gass.L=1", "gass", "unknown key; known: kind, about, experiment, gas", "gas"),
        ("gas.closure=grosman", "gas.closure", "'grosman' is not known; known: grossman", "grossman"),
        ("gas=3", "gas", "must be a section", None),
        ("gas=[{L=1}]", "gas", "must be a section", None),
        ("kind=evoluton", "kind", "'evoluton' is not known; known: evolution", "evolution"),
        ("kind=[1]", "kind", "[1] is not known", None),
        ("about.title=7", "about.title", "must be text", None),
        ("box.periodic=['z']", "box.periodic[0]", "'z' is not known; known: x, y", None),
        ("box.periodic=['y', 'y']", "box.periodic", "must not repeat", None),
        ("box.periodic=['x']", "wall.kind", "'vibrating' is not allowed; must be 'elastic'", None),
        ("mesh.cells=[128, 2]", "mesh.cells[1]", "must be at least 4", None),
        ("mesh.cells=[128, 8.0]", "mesh.cells[1]", "must be a whole number", None),
        ("mesh.cells=[128]", "mesh.cells", "must have 2 items", None),
        ("mesh.cells=[8, 8, 8]", "mesh.cells", "must have 2 items", None),
        ("mesh.cells=64", "mesh.cells", "must be a list", None),
        ("mesh.stretch=0.5", "mesh.stretch", "must be at least 1", None),
        ("wall.kind=vibratng", "wall.kind", "known: vibrating, thermal, elastic", "vibrating"),
        ("wall={W=1}", "wall.kind", "required; known: vibrating, thermal, elastic", None),
        ("wall=3", "wall", "must be a section", None),
        ("wall.V=3", "wall.V", "unknown key; known: kind, W", None),
        ("initial.amplitude=1", "initial.amplitude", "must be less than 1", None),
        ("initial.wave=0.5", "initial.wave", "must be a whole number", None),
        ("initial={kind=[]}", "initial.kind", "known: cosine", None),
        ("gas={L=1, K=1}", "gas.f", "required by the initial state 'cosine'", None),
        ("gas.f=0.95", "gas.f", "0.95 is not allowed; the initial state reaches close packing", None),
        (MODES % "[0.1]", "initial.amplitudes", "must have as many items as waves, 2", None),
        (MODES % "[0.5, -0.5]", "initial.amplitudes", "must add to less than 1", None),
        ("initial={kind='modes', waves=[], amplitudes=[]}", "initial.waves", "1 items or more", None),
        ("initial={kind='noise', seed=-1}", "initial.seed", "must be at least 0", None),
        (PROFILE % "", "initial.pressure", "exactly one of temperature and pressure", None),
        (PROFILE % ", pressure=[1, 1], temperature=[1, 1]", "initial.pressure", "exactly one of", None),
        (PROFILE % ", pressure=[1]", "initial.pressure", "as many items as positions", None),
        (PROFILE % ", pressure=[1, 0]", "initial.pressure[1]", "must be greater than 0", None),
        ((PROFILE % ", pressure=[1, 1]").replace("[0, 1]", "[1, 1]"), "initial.positions", "must increase", None),
        (RIEMANN % "[1.0, 0, 1]", "initial.left[0]", "must be less than 1", None),
        (RIEMANN % "[0.1]", "initial.left", "must have 3 items", None),
        (CHECKPOINT % "{kind='cosin'}", "initial.perturbation.kind", "known: cosine, modes, noise", "cosine"),
        (CHECKPOINT % "{kind='noise', amplitude=2}", "initial.perturbation.amplitude", "less than 1", None),
        ("initial={kind='checkpoint', path=''}", "initial.path", "must be the name of a file", None),
        ("time={}", "time.end", "required: time at which the run ends", None),
        (
            "time.integrator=godunof",
            "time.integrator",
            "'godunof' is not known; known: godunov, lagrange-remap",
            "godunov",
        ),
        ("time.cfl=1.1", "time.cfl", "must be at most 1", None),
        ("scheme.limiter=van-leer", "scheme.limiter", "known: minmod, van_leer, mc", "van_leer"),
        ("scheme.riemann=hlc", "scheme.riemann", "known: hllc, hllc_lm", "hllc"),
        ("output.times=[1, 1]", "output.times", "must increase", None),
        ("output.times=[1, 9e9]", "output.times", "must not go beyond time.end = 1290", None),
        ("output.history_every=-1", "output.history_every", "must be at least 0", None),
        ("output.keep=0", "output.keep", "must be at least 1", None),
        ("output.checkpoint_seconds=0", "output.checkpoint_seconds", "must be greater than 0", None),
        ("time.wall_limit=nan", "time.wall_limit", "nan is not allowed", None),
        ("gas.L", "gas.L", "not an override", None),
        ("=3", "=3", "not an override", None),
        ("gas..L=3", "gas..L=3", "not an override", None),
        ("gas.L.x=3", "gas.L.x", "gas.L is not a section", None),
        ("gas.L=", "gas.L=", "neither a TOML value nor a word", None),
        ("gas.L=[1", "gas.L=[1", "neither a TOML value nor a word", None),
        ("gas.L=1\nv2=3", "gas.L=1\\nv2=3", "neither", None),
        ("about.title=\udcff", "about.title=\\udcff", "not an override", None),
    ],
)
def test_one_complaint(override, key, problem, nearest):
    found = complaints(override)
    assert list(found) == [key]
    assert problem in found[key].problem
    assert found[key].nearest == nearest


@pytest.mark.parametrize("section", ["gas", "mesh", "initial", "time"])
def test_missing_section(section):
    text = "\n".join(line for line in MINIMAL.splitlines() if not line.startswith(section))
    assert "required" in complaints(text=text)[section].problem


def test_missing_kind():
    assert complaints(text="")["kind"].problem == f"required; known: {', '.join(KINDS)}"


def test_all_complaints_at_once_with_values():
    found = complaints(
        "gas.f=2", "mesh.cells=[1, 2]", "scheme.limitr=mc", "output.times=[1e6]", "wall.kind=odd", "nonsense"
    )
    assert set(found) == {
        "gas.f",
        "mesh.cells[0]",
        "mesh.cells[1]",
        "scheme.limitr",
        "output.times",
        "wall.kind",
        "nonsense",
    }
    assert (found["gas.f"].value, found["mesh.cells[0]"].value, found["wall.kind"].value) == (2, 1, "odd")
    assert found["scheme.limitr"].nearest == "limiter"


def test_message_reads_well():
    with pytest.raises(DeckError) as caught:
        parse(MINIMAL, ["gas.f=1.5", "time.integrator=godunof"], source="my.toml")
    assert str(caught.value).splitlines() == [
        "my.toml: 2 errors",
        "  gas.f: 1.5 is not allowed; must be less than 1",
        "  time.integrator: 'godunof' is not known; known: godunov, lagrange-remap (did you mean 'godunov'?)",
    ]


def test_overrides():
    deck = parse(MINIMAL, ["gas.tau = inf", "time.end=7", "output.times=[1, 2]", "about.title=a b/c.h5", "time.end=8"])
    assert (deck.gas.tau, deck.time.end, deck.output.times, deck.about.title) == (math.inf, 8.0, (1.0, 2.0), "a b/c.h5")
    overrides = ["initial.kind=checkpoint", "initial.path=out/x.h5", "initial.perturbation.kind=cosine"]
    deck = parse(MINIMAL, [*overrides, "initial.perturbation.amplitude=0.2"])
    assert deck.initial == FromCheckpoint(path="out/x.h5", perturbation=PATTERNS["cosine"](amplitude=0.2))


def test_switching_a_kind_drops_what_only_other_kinds_know():
    assert parse(MINIMAL, ["wall.kind=thermal"]).wall == Thermal()
    assert parse(MINIMAL, ["wall.temperature=2", "wall.kind=thermal"]).wall == Thermal(temperature=2)
    assert parse(MINIMAL, ["box.periodic=['x']", "wall.kind=elastic"]).wall == Elastic()
    noise = parse(MINIMAL, ["initial.kind=noise"]).initial
    assert (noise.amplitude, noise.seed) == (0.1, 0)
    nested = MINIMAL.replace("initial = {", 'initial = { perturbation = { kind = "cosine", wave = 3 }, path = "a",')
    nested = nested.replace('"cosine", amplitude = 0.1, wave = 2, temperature = 1.0', '"checkpoint"')
    assert parse(nested, ["initial.perturbation.kind=noise"]).initial.perturbation == PATTERNS["noise"]()


def test_switching_a_kind_keeps_overrides_and_misspellings():
    assert list(complaints("wall.kind=thermal", "wall.W=3")) == ["wall.W"]
    assert list(complaints("wall.kind=thermal", text=MINIMAL.replace("W =", "Q ="))) == ["wall.Q"]
    assert list(complaints("wall.kind=vibrating", text=MINIMAL.replace("W =", "temperature ="))) == ["wall.temperature"]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"kind = 'evolution'\ngas = {", "line 2"),
        (b"a = 1\na = 2", "line 2"),
        (b"a = 1\nb = '\xff'", "line 2"),
        (b"a = " + 5000 * b"[", "nested too deeply"),
        (b"a = " + 5000 * b"9", "not valid TOML"),
        (b"\x00", "line 1"),
        (b"\x89HDF\r\n", "line 1"),
    ],
)
def test_unreadable_content(tmp_path, content, problem):
    path = tmp_path / "my.toml"
    path.write_bytes(content)
    with pytest.raises(DeckError, match=problem) as caught:
        load(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["missing.toml", ".", "a\0b", "\ud800", "x" * 5000])
def test_unreadable_file(tmp_path, name):
    with pytest.raises(DeckError):
        load(f"{tmp_path}/{name}")


def test_load_reads_files_with_byte_order_mark(tmp_path):
    (tmp_path / "deck.toml").write_bytes(b"\xef\xbb\xbf" + MINIMAL.replace("\n", "\r\n").encode())
    assert load(tmp_path / "deck.toml") == parse(MINIMAL)


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["gas.tau=inf", "gas.K=1e-30", "gas.L=0.1"],
        ["wall.kind=elastic", "box.periodic=['x', 'y']", "time.tolerance=1e-5", "time.dt_max=3"],
        [MODES % "[0.1, -0.2]"],
        [PROFILE % ", pressure=[1, 2], velocity=[0, 1]"],
        [RIEMANN % "[0.1, -3, 1e16]"],
        [CHECKPOINT % "{kind='noise', seed=9223372036854775807}"],
        [r'about.title="""quotes " \\ \u0000 \u007f \u0085 \r\n é 😀"""'],
    ],
)
def test_round_trip(tmp_path, overrides):
    deck = parse(MINIMAL, overrides)
    (tmp_path / "deck.toml").write_text(dumps(deck), encoding="utf-8")
    assert load(tmp_path / "deck.toml") == deck
    assert "alpha = 1.15" in dumps(deck)


LEAVES = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(),
    st.dates(),
    st.sampled_from(
        ["cosine", "thermal", "noise", 10**400, 2**9999, 0.5, [8, 8], [[1], {}], {"kind": "cosine"}, {"kind": {}}]
    ),
)
NAMES = [*EvolutionDeck.model_fields, "L", "f", "cells", "waves", "W"]
KEYS = st.one_of(st.sampled_from(NAMES), st.text(max_size=5))
GARBAGE = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4))
OVERRIDES = st.builds("{}.{}={}".format, KEYS, KEYS, st.one_of(GARBAGE, st.text(st.characters(), max_size=20)))


@settings(max_examples=100, deadline=None)
@given(st.lists(st.one_of(OVERRIDES, st.text(st.characters(exclude_categories=[]))), max_size=4))
def test_any_overrides_give_a_deck_or_a_deck_error(overrides):
    with contextlib.suppress(DeckError):
        deck = parse(MINIMAL, overrides)
        assert parse(dumps(deck)) == deck


@settings(max_examples=100, deadline=None)
@given(st.dictionaries(KEYS, GARBAGE, max_size=6), st.booleans())
def test_any_data_give_a_deck_or_a_deck_error(garbage, based_on_minimal):
    data = parse(MINIMAL).model_dump() if based_on_minimal else {}
    with contextlib.suppress(DeckError):
        validate({**data, "kind": "evolution", **garbage})


def test_reference_names_every_key_and_kind():
    text = reference()
    models = [table.section(name) for table in (KINDS, WALLS, INITIAL_STATES, PATTERNS) for name in table]
    assert all(
        f"`{key}`" in text or f"[{key}]" in text for model in models for key in model.model_fields if key != "kind"
    )
    assert all(f'[wall] kind = "{kind}"' in text for kind in WALLS)
    assert all(f'[initial] kind = "{kind}"' in text for kind in INITIAL_STATES)
    assert "| `f` | number | none | > 0, < 1 |" in text


def test_tables_agree_with_the_kinds_of_their_models():
    for table in (KINDS, WALLS, INITIAL_STATES, PATTERNS):
        assert all(table.section(kind).model_fields["kind"].default == kind for kind in table)


def test_a_deck_is_read_without_the_compiler():
    """Nor is anything else imported that takes long, though sections stand beside laws and initial states."""
    for deck in (MINIMAL, MINIMAL.replace('"cosine", amplitude = 0.1, wave = 2', '"checkpoint", path = "a.h5"')):
        deck = deck.replace(", temperature = 1.0", "") if "checkpoint" in deck else deck
        code = f"from hydro.deck import parse; import sys; parse({deck!r}); print(*sys.modules)"
        printed = subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        ).stdout.split()
        assert "hydro.gas.grossman" in printed
        assert not {"numba", "scipy", "h5py", "matplotlib", "pandas", "xarray", "pint"} & set(printed)
