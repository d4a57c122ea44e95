"""Looking at runs: frames and movies, XDMF as the VTK library reads it, xarray, history."""

from __future__ import annotations

import doctest
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import get_args

import h5py
import imageio.v3 as imageio
import numpy as np
import pandas as pd
import pytest
from conftest import PROBLEMS, summary_of
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image

import hydro
from hydro.choices import SCALES
from hydro.cli import MOVIE_EPILOG, main
from hydro.deck import load
from hydro.deck.evolution import Colours, Limits, Movie
from hydro.driver.frames import Frames
from hydro.errors import CheckpointError, DeckError, RunFailed
from hydro.mesh import Mesh
from hydro.movies import video
from hydro.movies.frames import frame_time, frames, read_frame
from hydro.movies.movie import interval_of, repeats
from hydro.movies.moving import MovingPicture, averages
from hydro.observables import CLUSTERING
from hydro.output import dataset
from hydro.output.checkpoint import FIELDS, read_checkpoint
from hydro.output.files import partial
from hydro.output.folder import RunFolder
from hydro.output.xdmf import Series
from hydro.setup import gas_of, grain_diameter, mesh_of
from hydro.state import State

ROOT = Path(__file__).parent.parent
SMALL = ("mesh.cells=[16,32]", "mesh.stretch=4.0", "time.end=3.0", "output.times=[1.0,2.0,3.0]")
MOVIE = ("output.movie=true", "output.movie_every=0.25", "movie.gif=false")
PICTURES_MAY_COST = 50e6  # bytes that the peak memory may grow by when a movie gets ten times longer


def saved_in(folder):
    """The checkpoints of a run, in order of time."""
    return [read_checkpoint(path) for path in sorted(folder.glob("checkpoints/*.h5"))]


# Frames


@pytest.mark.parametrize("integrator", ["godunov", "lagrange-remap"])
def test_a_movie_leaves_no_trace_in_the_run(run_deck, integrator):
    words = (*SMALL, f"time.integrator={integrator}")
    plain, filmed = run_deck("fig4", *words, folder="plain")[0], run_deck("fig4", *words, *MOVIE, folder="filmed")[0]
    for without, with_movie in zip(saved_in(plain), saved_in(filmed), strict=True):
        assert without.steps == with_movie.steps
        np.testing.assert_array_equal(without.conserved, with_movie.conserved)
    assert (plain / "history.csv").read_bytes() == (filmed / "history.csv").read_bytes()
    assert not (plain / "frames").exists() and (filmed / "movie.mp4").stat().st_size > 0


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A run with frames, and a row of history for every step."""
    folder = tmp_path_factory.mktemp("filmed") / "run"
    words = [*SMALL, *MOVIE, "time.integrator=godunov", "output.history_every=1e-5"]
    assert main([str(PROBLEMS / "fig4.toml"), *words, "--output", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture
def copy(filmed, tmp_path):
    """A copy of that run, to be spoilt."""
    return Path(shutil.copytree(filmed, tmp_path / "copy"))


def test_frames_are_of_the_first_step_after_each_interval_and_of_the_last(filmed):
    steps = hydro.read_history(filmed).index.to_numpy()
    due = steps[np.searchsorted(steps, np.arange(0.0, 3.0, 0.25))]
    assert [frame_time(path) for path in frames(filmed / "frames")] == [*due, 3.0]


def test_a_frame_is_the_density_in_single_precision(filmed):
    last = frames(filmed / "frames")[-1]
    np.testing.assert_array_equal(read_frame(last), saved_in(filmed)[-1].conserved[0].astype(np.float32))
    with h5py.File(last) as file:
        assert file.attrs["time"] == 3.0 and file["density"].attrs["units"] == "n_c"


def test_a_run_that_goes_back_takes_the_same_frames_again(filmed, copy):
    """Frames later than the place where a run takes up go, and the next one is due as if nothing had happened."""
    before = [frame_time(path) for path in frames(filmed / "frames")]
    tracker = Frames(copy / "frames", 0.25, begin=2.0, seen=lambda run: run.state)
    assert [frame_time(path) for path in frames(copy / "frames")] == [at for at in before if at <= 2.0]
    deck = load(filmed / "deck.toml")
    steps = hydro.read_history(filmed).index
    for at in steps[steps >= 2.0]:
        tracker.look(Moment(deck, float(at)))
    assert [frame_time(path) for path in frames(copy / "frames")] == before


class Moment:
    """As much of a run as frames look at."""

    def __init__(self, deck, at):
        self.end, self.state = deck.time.end, State.of(gas_of(deck), mesh_of(deck), 0.1, 1.0, time=at)


def test_a_restarted_run_has_the_frames_series_and_movie_of_an_undisturbed_one(filmed, copy):
    """A kill has left frames later than the newest checkpoint, and no movie."""
    for path in [*sorted(copy.glob("checkpoints/*.h5"))[1:], copy / "summary.json", copy / "movie.mp4"]:
        path.unlink()
    taken = [path.stat().st_mtime_ns for path in frames(copy / "frames")]
    assert main(["restart", str(copy), "movie.colours=magma", "--quiet"]) == 0
    for mine, other in zip(frames(copy / "frames"), frames(filmed / "frames"), strict=True):
        assert mine.name == other.name and mine.read_bytes() == other.read_bytes()
    again = [path.stat().st_mtime_ns > before for path, before in zip(frames(copy / "frames"), taken, strict=True)]
    assert again == [frame_time(path) > 1.0 for path in frames(copy / "frames")]
    assert (copy / "checkpoints.xdmf").read_text() == (filmed / "checkpoints.xdmf").read_text()
    assert (copy / "movie.mp4").exists()


def test_a_new_run_removes_the_frames_and_the_movie_of_the_old(run_deck, filmed, copy):
    assert main([str(copy / "deck.toml"), "output.movie=false", "--output", str(copy), "--overwrite", "--quiet"]) == 0
    assert not list(copy.glob("frames/*")) and not list(copy.glob("movie.*"))


# Movies


def metadata(movie):
    """What ffmpeg says of a movie."""
    return imageio.immeta(movie, plugin="FFMPEG")


def test_the_movie_plays_in_browsers(copy):
    assert main(["movie", str(copy), "gif=true", "--quiet"]) == 0
    said = metadata(copy / "movie.mp4")
    assert said["codec"] == "h264" and said["pix_fmt"].startswith("yuv420p")
    assert not said["size"][0] % 2 and not said["size"][1] % 2
    assert said["duration"] == pytest.approx(9.0, abs=0.1)  # the shortest, and the last picture's pause
    content = (copy / "movie.mp4").read_bytes()
    assert 0 < content.index(b"moov") < content.index(b"mdat")  # starts before all of it is there
    with Image.open(copy / "movie.gif") as gif:
        assert gif.n_frames > 5 and max(gif.size) == 480 and gif.info["loop"] == 0


def test_a_run_without_frames_has_a_movie_of_its_checkpoints(copy):
    shutil.rmtree(copy / "frames")
    assert main(["movie", str(copy), "gif=false", "--quiet"]) == 0
    assert metadata(copy / "movie.mp4")["duration"] == pytest.approx(9.0, abs=0.1)


def test_a_movie_can_be_made_while_the_run_goes_on(tmp_path):
    folder = tmp_path / "run"
    words = ["mesh.cells=[64,128]", "time.integrator=godunov", "output.movie=true", "output.movie_every=0.1"]
    run = [sys.executable, "-m", "hydro", str(PROBLEMS / "fig4.toml"), *words, "--output", str(folder), "--quiet"]
    with subprocess.Popen(run, stderr=subprocess.DEVNULL) as process:
        try:
            deadline = time.monotonic() + 120.0
            while len(list(folder.glob("frames/t*.h5"))) < 3 and time.monotonic() < deadline:
                time.sleep(0.05)
            assert main(["movie", str(folder), "gif=false", "--quiet"]) == 0
            assert process.poll() is None
        finally:
            process.kill()
    assert metadata(folder / "movie.mp4")["duration"] == pytest.approx(9.0, abs=0.1)


def test_damaged_frames_are_named_and_left_out(copy, capsys):
    cut, flipped, *_ = frames(copy / "frames")
    os.truncate(cut, 1000)
    content = bytearray(flipped.read_bytes())
    where = content.index(b"\x78\x5e") + 50  # in the compressed density
    content[where] ^= 0xFF
    flipped.write_bytes(content)
    assert main(["movie", str(copy), "gif=false", "limits=run", "--quiet"]) == 0
    said = capsys.readouterr().err
    assert cut.name in said and flipped.name in said and "Traceback" not in said
    for path in frames(copy / "frames"):
        path.write_bytes(b"not an HDF5 file")
    before = (copy / "movie.mp4").read_bytes()
    for limits in ("frame", "run"):
        assert main(["movie", str(copy), f"limits={limits}", "--quiet"]) == 2
        assert "nothing to show" in capsys.readouterr().err
    assert (copy / "movie.mp4").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["colours=viridiss"], "did you mean 'viridis'"),
        (["movie.colors=gray"], "did you mean 'colours'"),
        (["scale=logarithmic"], "linear, log"),
        (["frames_per_second=0"], "must be at least 1"),
        (["traces=maybe"], "true or false"),
        (["fast"], "section.key=value"),
    ],
)
def test_bad_looks_are_refused(filmed, words, expected, capsys):
    assert main(["movie", str(filmed), *words]) == 2
    assert expected in capsys.readouterr().err


def test_frames_cannot_fill_the_disk(capsys):
    assert main(["check", str(PROBLEMS / "fig4.toml"), "output.movie=true", "output.movie_every=1e-20"]) == 2
    assert "output.movie_every" in capsys.readouterr().err


def test_movies_are_made_of_evolutions(run_deck, tmp_path, capsys):
    folder, _ = run_deck("fig3a", "mesh.cells=[16,16]")
    assert main(["movie", str(folder)]) == 2 and "'steady'; movies are made of evolutions" in capsys.readouterr().err
    assert main(["movie", str(tmp_path)]) == 2 and "no folder of a run" in capsys.readouterr().err


def test_a_movie_that_fails_leaves_the_run_complete_and_nothing_half(run_deck, monkeypatch, capsys):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    folder, code = run_deck("fig4", *SMALL, *MOVIE)
    assert code == 3 and "the run is complete" in capsys.readouterr().err
    assert summary_of(folder)["completed"] and not [path for path in folder.iterdir() if "movie" in path.name]


@pytest.mark.parametrize("name", ["movie.mp4", "movie.gif"])
def test_a_movie_whose_end_is_lost_is_not_kept(tmp_path, monkeypatch, name):
    """An encoder that takes all pictures, but finds no room for the end of its file."""
    encoder = tmp_path / "ffmpeg"
    encoder.write_text(
        f'#!/bin/sh\n{get_ffmpeg_exe()} "$@"\nfor file; do :; done\n'
        f'case "$file" in *{name}) truncate --size=-20 "$file"; esac\n'
    )
    encoder.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(encoder))
    pictures = np.random.default_rng(0).integers(0, 255, (30, 32, 32, 4), np.uint8)
    with pytest.raises(RunFailed, match="encoder failed"):
        video.mp4(tmp_path / "movie.mp4", pictures, 25)
        video.gif(tmp_path / "movie.gif", tmp_path / "movie.mp4", 25)
    assert not (tmp_path / name).exists() and not partial(tmp_path)


def test_a_gif_can_be_made_where_names_are_odd(tmp_path, monkeypatch):
    odd = tmp_path / "a, 'b'; [c]: \\d"
    odd.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(odd))
    video.mp4(odd / "movie.mp4", np.random.default_rng(0).integers(0, 255, (30, 32, 32, 4), np.uint8), 25)
    video.gif(odd / "movie.gif", odd / "movie.mp4", 25)
    assert imageio.imread(odd / "movie.gif").shape == (15, 480, 480, 3)


def test_every_key_of_the_look_is_in_the_help_and_known_to_the_pictures():
    words = re.findall(r"\w+", MOVIE_EPILOG)
    assert set(words) >= {*Movie.model_fields, *get_args(Colours), *SCALES, *get_args(Limits)}


def test_simulated_time_passes_evenly():
    uneven = [0.0, 1.0, 1.5, 1.9, 4.0, 9.0, 10.0]
    interval = interval_of(uneven, every=1.0, rate=1)
    assert interval == pytest.approx(10.0 / 8.0)
    counts = repeats(uneven, interval, rate=1)
    shown = [at for at, count in zip(uneven, counts, strict=True) for _ in range(count)]
    for tick, at in enumerate(shown[:-1]):
        assert at == max(moment for moment in uneven if moment <= tick * interval)
    assert shown[-1] == 10.0
    steady = [0.1 * k for k in range(1001)]  # exactly on the cadence: none twice, none left out
    assert repeats(steady, interval_of(steady, every=0.1, rate=25), rate=25) == [1] * 1000 + [25]
    crowded = np.concatenate([np.linspace(0.0, 1.0, 1000), [1000.0]]).tolist()  # no hours of one picture
    assert sum(repeats(crowded, interval_of(crowded, every=1e-3, rate=25), rate=25)) < 1100


def memory_of_a_movie(folder, count):
    """Peak memory, in bytes, of a process that makes a movie of so many frames, and of its encoder."""
    kept = frames(folder / "frames")
    for number in range(count):
        shutil.copy(kept[number % len(kept)], folder / "frames" / f"t{100.0 + number}.h5")
    code = (
        "import json, resource as r, sys; from hydro.cli import main; assert main(sys.argv[1:]) == 0; "
        "print(json.dumps([r.getrusage(who).ru_maxrss * 1024 for who in (r.RUSAGE_SELF, r.RUSAGE_CHILDREN)]))"
    )
    words = [sys.executable, "-c", code, "movie", str(folder), "--quiet"]
    return np.array(json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout))


def test_memory_does_not_grow_with_the_length_of_a_movie(copy):
    """Ten times more pictures: 0.3 GB more if they were kept."""
    short, long = memory_of_a_movie(copy, 20), memory_of_a_movie(copy, 200)
    assert np.all(long - short < PICTURES_MAY_COST)


# Pictures of movies


def stripes(cells, stretch=1.0, aspect_ratio=2.0):
    """A mesh, and a density that is larger in the first third of the cells in x, and in the last quarter in y."""
    mesh = Mesh.rectangle(cells, aspect_ratio, stretch)
    density = np.full(cells, 0.1)
    density[: cells[0] // 3] = 0.2
    density[:, -cells[1] // 4 :] *= 2.0
    return mesh, density


def drawn(picture):
    """The shades in the map of a picture, shape (height, width), y upward; larger is darker."""
    pixels = np.asarray(picture.at(0.0, picture.density)).astype(float)[::-1, :, 0]
    box = picture.figure.axes[0].bbox
    left, bottom = round(box.x0), round(box.y0)
    return 255.0 - pixels[bottom : bottom + round(box.height), left : left + round(box.width)]


@pytest.mark.parametrize(("cells", "stretch"), [((9, 8), 1.0), ((30, 16), 20.0), ((600, 1200), 5.0)])
def test_cells_are_drawn_where_they_are(cells, stretch):
    """On a stretched mesh too, and on one that is finer than the picture."""
    mesh, density = stripes(cells, stretch)
    picture = MovingPicture(mesh, CLUSTERING.span, Movie(), None, None, digits=0)
    picture.density = density
    shades = drawn(picture)[2:-2, 2:-2]
    height, width = drawn(picture).shape
    across, up = np.argmax(shades[10] < 100.0) + 2, np.argmax(shades[:, 10] > 200.0) + 2
    assert across == pytest.approx(mesh.x_faces[cells[0] // 3] * width, abs=1.0)
    assert up == pytest.approx(0.75 * height, abs=1.0)


def test_pixels_are_averages():
    mesh, density = stripes((30, 16), stretch=20.0)
    pixels = np.linspace(0.0, 1.0, 8)
    coarse = averages(density, mesh.x_faces, pixels)
    np.testing.assert_allclose(coarse.sum(axis=0) / 7.0, mesh.dx @ density, rtol=1e-13)
    fine = averages(density, mesh.x_faces, mesh.x_faces)
    np.testing.assert_allclose(fine, density, rtol=1e-12)


@pytest.mark.parametrize("look", [Movie(), Movie(scale="log", colours="viridis"), Movie(limits="run")])
def test_what_moves_leaves_no_trace_in_the_next_picture(look):
    """A picture that has shown another moment is, pixel by pixel, one that has not."""
    mesh, density = stripes((30, 16))
    history = pd.DataFrame({"time": [0.0, 1.0], "wall_max": [0.1, 0.4], "wall_min": [0.1, 0.05]})
    limits = (0.01, 0.5) if look.limits == "run" else None
    used, fresh = (MovingPicture(mesh, CLUSTERING.span, look, limits, history, digits=1) for _ in range(2))
    first = np.array(used.at(0.0, np.full(mesh.cells, 0.1)))
    again, new = np.array(used.at(0.7, density)), np.array(fresh.at(0.7, density))
    np.testing.assert_array_equal(again, new)
    assert np.abs(first.astype(float) - new).max() > 100.0


def test_the_scale_is_that_of_the_moment_or_of_the_run():
    mesh, density = stripes((30, 16))
    own, common = (
        MovingPicture(mesh, CLUSTERING.span, Movie(), limits, None, digits=0) for limits in (None, (0.0, 0.8))
    )
    darkest = []
    for picture in (own, common):
        for factor in (0.5, 1.0):
            picture.density = factor * density
            darkest.append(drawn(picture)[2:-2, 2:-2].max())
    assert darkest[0] == darkest[1] == 255.0
    assert darkest[2] < darkest[3] < 150.0


# XDMF


def vtk_reader(page):
    """VTK's reader of a page, and the times that it found."""
    xdmf = pytest.importorskip("vtkmodules.vtkIOXdmf2", reason="needs the VTK library with its XDMF reader")
    reader = xdmf.vtkXdmfReader()
    reader.SetFileName(str(page))
    reader.UpdateInformation()
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

    return reader, reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS())


def vtk_fields(reader, at):
    """Faces in x and y, and cell fields of shape (nx, ny), as VTK has them at a time."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader.UpdateTimeStep(at)
    grid = reader.GetOutputDataObject(0)
    faces = [vtk_to_numpy(grid.GetXCoordinates()), vtk_to_numpy(grid.GetYCoordinates())]
    nx, ny = (side.size - 1 for side in faces)
    cells = grid.GetCellData()
    fields = {}
    for name, _, _ in FIELDS:  # cell (i, j) of a rectilinear grid has the number i + nx j
        values = vtk_to_numpy(cells.GetArray(name))
        fields[name] = np.array([[values[i + nx * j] for j in range(ny)] for i in range(nx)])
    return faces, fields


def test_vtk_opens_the_whole_series(filmed, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # files are found from where the page is
    reader, times = vtk_reader(filmed / "checkpoints.xdmf")
    saved = saved_in(filmed)
    assert times == tuple(moment.time for moment in saved) == (1.0, 2.0, 3.0)
    for moment in saved:
        (x_faces, y_faces), fields = vtk_fields(reader, moment.time)
        np.testing.assert_array_equal(x_faces, moment.mesh.x_faces)
        np.testing.assert_array_equal(y_faces, moment.mesh.y_faces)
        for (name, _, _), field in zip(FIELDS, moment.conserved, strict=True):
            np.testing.assert_array_equal(fields[name], field)
    assert not np.array_equal(saved[0].conserved, saved[2].conserved)


def test_the_series_is_of_the_checkpoints_that_are_there(copy):
    series = Series(copy / "checkpoints.xdmf", copy / "checkpoints", mesh_of(load(copy / "deck.toml")))
    first, second, _ = sorted(copy.glob("checkpoints/*.h5"))
    series.update()
    second.unlink()
    first.write_bytes(b"not an HDF5 file")
    (copy / "checkpoints" / ".4.h5").write_bytes(b"half a file")
    series.update()  # remembers the first, which it has read
    assert vtk_reader(copy / "checkpoints.xdmf")[1] == (1.0, 3.0)
    Series(series.page, series.folder, series.mesh).update()
    assert "".join(re.findall(r'Value="(.*?)"', series.page.read_text())) == "3.0"


# Python


def test_a_run_opens_with_coordinates_units_and_derived_fields(filmed):
    run, deck = hydro.open_run(filmed), load(filmed / "deck.toml")
    mesh, gas = mesh_of(deck), gas_of(deck)
    assert dict(run.sizes) == {"time": 3, "x": 16, "y": 32} and run.density.dims == ("time", "x", "y")
    np.testing.assert_array_equal(run.time, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(run.x, mesh.x)
    np.testing.assert_array_equal(run.y, mesh.y)
    assert all(run[name].attrs.keys() >= {"units", "long_name"} for name in run.variables)
    assert run.deck == (filmed / "deck.toml").read_text() and run.hydro_version == hydro.__version__
    saved = saved_in(filmed)[1]
    state, now = State(gas, mesh, saved.conserved), run.sel(time=2.0)
    diameter = grain_diameter(deck)
    expected = {
        "density": state.density,
        "velocity_x": state.velocity[0],
        "velocity_y": state.velocity[1],
        "temperature": state.temperature,
        "pressure": state.pressure,
        "sound_speed": gas.sound_speed(state.density, state.temperature),
        "mach_number": state.mach,
        "mean_free_path": diameter * gas.mean_free_path(state.density),
    }
    for name, field in expected.items():
        np.testing.assert_allclose(now[name], field, rtol=1e-12, err_msg=name)
    slope = np.hypot(np.gradient(state.density, mesh.x, axis=0), np.gradient(state.density, mesh.y, axis=1))
    knudsen = expected["mean_free_path"] * slope / state.density
    np.testing.assert_allclose(now.knudsen_number, knudsen, rtol=1e-12)


def test_a_long_run_opens_without_reading_a_field(copy, monkeypatch):
    """A thousand checkpoints; then one field of one of them is read for one number."""
    first, *rest = sorted(copy.glob("checkpoints/*.h5"))
    for path in rest:
        path.unlink()
    for number in range(1, 1000):
        first.with_name(f"{number:04d}.h5").hardlink_to(first)
    read = []

    def counting(path, name, original=dataset.read_field):
        read.append((path.name, name))
        return original(path, name)

    monkeypatch.setattr(dataset, "read_field", counting)
    started = time.perf_counter()
    run = hydro.open_run(copy)
    assert run.sizes["time"] == 1000 and not read
    assert time.perf_counter() - started < 30.0
    assert float(run.density[700].max()) == read_checkpoint(first).conserved[0].max()
    assert read == [("0700.h5", "density")]


def test_a_run_that_goes_on_or_was_damaged_opens(copy):
    (copy / "summary.json").unlink()
    first, second, third = sorted(copy.glob("checkpoints/*.h5"))
    os.truncate(first, 1000)
    (copy / "checkpoints" / ".0004.h5").write_bytes(b"half a file")
    with pytest.warns(UserWarning, match=first.name):
        run = hydro.open_run(copy)
    assert run.time.values.tolist() == [2.0, 3.0]
    third.unlink()
    assert float(run.density[0].min()) > 0.0
    with pytest.raises(CheckpointError, match=third.name):
        run.density[1].compute()
    second.unlink()
    with pytest.warns(UserWarning), pytest.raises(CheckpointError, match="no checkpoints"):
        hydro.open_run(copy)


def test_steady_states_and_branches_open(run_deck):
    folder, _ = run_deck("fig3a", "mesh.cells=[16,16]", folder="steady")
    steady = hydro.open_run(folder)
    assert steady.state.values[0] == "steady" and steady.sizes["state"] > 1
    assert float(steady.mach_number.sel(state="steady").max()) < 1e-12
    folder, _ = run_deck("branches", "mesh.cells=[8,8]", "branch.samples=3", "branch.points=2", folder="branch")
    branch = hydro.open_run(folder)
    points = summary_of(folder)["points"]
    assert branch.sizes["point"] == len(points) and branch.f.values.tolist() == [point["f"] for point in points]
    means = branch.density.weighted(branch.dx * branch.dy).mean(("x", "y"))
    np.testing.assert_allclose(means, branch.f, rtol=1e-10)


def test_what_cannot_be_opened_says_why(run_deck, tmp_path):
    with pytest.raises(DeckError, match="no folder of a run"):
        hydro.open_run(tmp_path)
    with pytest.raises(DeckError, match="no folder of a run"):
        hydro.read_history(tmp_path)
    folder, _ = run_deck("fig2", "stability.f.count=4", "stability.L=[5e4]")
    with pytest.raises(DeckError, match="keeps no states"):
        hydro.open_run(folder)
    with pytest.raises(DeckError, match=r"no history\.csv"):
        hydro.read_history(folder)
    deck = RunFolder(folder).deck
    deck.write_text(
        'kind = "branch"\ngas = { L = 5e4, f = 0.0235 }\nmesh = { cells = [8, 8] }\n'
        'branch = { parameter = "aspect_ratio", start = 0.5, stop = 1.0 }\n'
    )
    with pytest.raises(DeckError, match="no mesh in common"):
        hydro.open_run(folder)


def test_history_in_one_call(copy, tmp_path):
    history = hydro.read_history(copy)
    assert history.index.name == "time" and history.index[-1] == 3.0 and history.wall_max.iloc[-1] > 0.0
    history.to_parquet(tmp_path / "history.parquet")
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "history.parquet"), history)
    path = copy / "history.csv"
    path.write_bytes(path.read_bytes()[:-20])  # as a kill may leave it
    pd.testing.assert_frame_equal(hydro.read_history(copy), history.iloc[:-1])
    path.write_text("time,wall")
    with pytest.raises(DeckError, match="no rows"):
        hydro.read_history(copy)


def test_the_package_is_light_to_import():
    code = "import sys, hydro; print(sorted(sys.modules))"
    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'hydro'" in modules and "'numpy'" not in modules
    with pytest.raises(AttributeError, match="open_runs"):
        _ = hydro.open_runs


# The page about all this


def test_the_session_of_the_page_runs(tmp_path, monkeypatch, capsys):
    """Its commands, then its Python, in one place."""
    page = ROOT / "docs" / "looking.md"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "problems").symlink_to(PROBLEMS)
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    commands = re.findall(r"^    python -m hydro (.*)$", text, flags=re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        assert main([*shlex.split(command), "--quiet"]) == 0, command
    capsys.readouterr()
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted > 10 and not result.failed, capsys.readouterr().out
