"""What disks, kills and people do to the folder of a run: an error that says so, or a fall back; never a lost state."""

from __future__ import annotations

import errno
import fcntl
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import differences, outcome, restart
from test_restart import check_series, deck, times_saved
from zygote import draw_nothing

import hydro.driver.keeper
from hydro.cli import main
from hydro.errors import CheckpointError
from hydro.output import files
from hydro.output.checkpoint import checkpoint_times, read_checkpoint, sealed

INTEGRATOR = "lagrange-remap"  # remembers more than godunov
BYTES = 100  # damaged one at a time


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch):
    draw_nothing(monkeypatch.setattr)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        draw_nothing(patch.setattr)
        folder = tmp_path_factory.mktemp("undisturbed") / "run"
        assert main([*deck(INTEGRATOR), "--output", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture(scope="module")
def expected(undisturbed):
    return outcome(undisturbed)


@pytest.fixture
def copy(undisturbed, tmp_path):
    """A copy of the run, to be spoilt."""
    return Path(shutil.copytree(undisturbed, tmp_path / "copy"))


def checkpoints(folder):
    return sorted(folder.glob("checkpoints/*.h5"))


def message_of(capsys):
    message = capsys.readouterr().err
    assert "Traceback" not in message
    return message


# A disk that is full


def contents(folder):
    return {path: path.read_bytes() for path in checkpoints(folder)}


def full(*arguments, **options):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


FAILING = {
    "write": (Path, "write_bytes"),
    "fsync": (files.os, "fsync"),
    "rename": (Path, "replace"),
    "open": (files.tempfile, "mkstemp"),
}


@pytest.mark.parametrize("operation", list(FAILING))
def test_a_disk_that_gets_full_ends_a_run_with_what_was_saved(
    operation, expected, undisturbed, tmp_path, monkeypatch, capsys
):
    """The operation fails from the third checkpoint on, until there is space again."""
    folder = tmp_path / "run"
    write = hydro.driver.keeper.write_checkpoint

    def write_until(path, saved):
        if len(checkpoints(folder)) == 2:
            patch.setattr(*FAILING[operation], full)
        write(path, saved)

    with monkeypatch.context() as patch:
        patch.setattr("hydro.driver.keeper.write_checkpoint", write_until)
        assert main([*deck(INTEGRATOR), "--output", str(folder), "--quiet"]) == 3
        message = message_of(capsys)
        assert "No space left on device" in message and str(checkpoints(folder)[1]) in message
    before = contents(folder)
    assert [path.name for path in before] == [path.name for path in checkpoints(undisturbed)[:2]]
    assert all(read_checkpoint(path) for path in before)
    assert restart(folder) == 0 and not differences(folder, expected)
    assert before.items() <= contents(folder).items()
    assert not list(folder.rglob(f"{files.PARTIAL}*"))


def test_a_history_that_cannot_be_written_ends_a_run(expected, tmp_path, monkeypatch, capsys):
    """A part of the row gets onto the disk."""
    folder, opened = tmp_path / "run", Path.open

    def open_full(self, mode="r", **options):
        file = opened(self, mode, **options)
        if mode == "a" and self.name == "history.csv" and self.exists() and self.stat().st_size > 5000:
            file.write("0.123,4.5")
            file.close()
            full()
        return file

    monkeypatch.setattr(Path, "open", open_full)
    assert main([*deck(INTEGRATOR), "--output", str(folder), "--quiet"]) == 3
    assert "No space left on device" in message_of(capsys)
    monkeypatch.setattr(Path, "open", opened)
    assert (folder / "history.csv").read_text().endswith("0.123,4.5")
    assert restart(folder) == 0 and not differences(folder, expected)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of its own: `small_disk(options)` mounts it anew with these."""
    place = tmp_path / "disk"
    place.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", place]
    mounted = subprocess.run(words, capture_output=True, text=True)
    if mounted.returncode:
        pytest.skip(f"no file system may be mounted here: {mounted.stderr.strip()}")

    def remount(options):
        subprocess.run(["mount", "-o", f"remount,{options}", place], check=True)
        return place

    yield remount
    subprocess.run(["umount", "-l", place], check=True)


@pytest.mark.parametrize("kilobytes", [64, 128, 192])
def test_a_small_disk(kilobytes, expected, small_disk, capsys):
    """The run, which needs some 300 kilobytes, gets onto the disk when that has grown."""
    folder = small_disk(f"size={kilobytes}k") / "run"
    assert main([*deck(INTEGRATOR), "--output", str(folder), "--quiet"]) == 3
    assert "No space left on device" in message_of(capsys)
    before = contents(folder)
    assert all(read_checkpoint(path) for path in before)
    small_disk("size=8m")
    assert restart(folder) == 0 and not differences(folder, expected)
    assert before.items() <= contents(folder).items()


def test_a_small_disk_and_frames(small_disk, capsys):
    folder = small_disk("size=96k") / "run"
    words = ["output.movie=true", "output.movie_every=0.001", "output.checkpoint_every=10.0"]
    assert main([*deck(INTEGRATOR), *words, "--output", str(folder), "--quiet"]) == 3
    assert "No space left on device" in message_of(capsys)
    small_disk("size=8m")
    assert restart(folder) == 0


def test_a_folder_that_may_only_be_read(small_disk, undisturbed, capsys):
    place = small_disk("size=8m")
    shutil.copytree(undisturbed, place / "run")
    checkpoints(place / "run")[-1].unlink()
    before = contents(place / "run")
    small_disk("ro")
    assert restart(place / "run") == 2
    assert "cannot be written" in message_of(capsys)
    assert main([*deck(INTEGRATOR), "--output", str(place / "new"), "--quiet"]) == 2
    assert "cannot be written" in message_of(capsys)
    assert contents(place / "run") == before


def test_a_folder_that_may_only_be_read_without_a_mount(copy, monkeypatch, capsys):
    before = contents(copy)
    monkeypatch.setattr("os.access", lambda *_: False)
    assert restart(copy) == 2 and "cannot be written" in message_of(capsys)
    assert contents(copy) == before


# Damaged checkpoints


def damaged(content, chance, way):
    """The content of a file, cut at a random byte or with a random bit of one flipped; and where."""
    at = chance.randrange(len(content))
    if way == "cut":
        return content[:at], at
    return content[:at] + bytes([content[at] ^ 1 << chance.randrange(8)]) + content[at + 1 :], at


@pytest.mark.parametrize("way", ["cut", "flipped"])
def test_no_damaged_checkpoint_is_believed(way, copy):
    """Neither is any taken for good, nor does looking at it end but in an error that names it."""
    chance, path = random.Random(way), checkpoints(copy)[-1]
    content = path.read_bytes()
    for _ in range(BYTES):
        spoilt, at = damaged(content, chance, way)
        path.write_bytes(spoilt)
        with pytest.raises(CheckpointError, match=path.name):
            read_checkpoint(path)
            pytest.fail(f"byte {at} was not missed")
        times, troubles = checkpoint_times(copy / "checkpoints")
        assert len(times) + len(troubles) == len(checkpoints(copy))


@pytest.mark.parametrize("way", ["cut", "flipped"])
def test_a_restart_skips_a_damaged_checkpoint(way, copy, expected, capsys):
    """Every tenth of those damages, each in a run of its own that goes on to the same bits."""
    chance, path = random.Random(f"{way} restart"), checkpoints(copy)[-1]
    content = path.read_bytes()
    for _ in range(BYTES // 10):
        spoilt, at = damaged(content, chance, way)
        path.write_bytes(spoilt)
        assert restart(copy) == 0, f"byte {at}"
        assert path.name in message_of(capsys)
        assert not differences(copy, expected), f"byte {at}"
        assert path.with_name(f"{path.name}.damaged").read_bytes() == spoilt
        check_series(copy)


def rewritten(path, change):
    """Let `change(file)` spoil a checkpoint whose checksum is right all the same."""
    scratch = path.with_name(".scratch")
    scratch.write_bytes(path.read_bytes())
    with h5py.File(scratch, "r+") as file:
        change(file)
    path.write_bytes(sealed(scratch.read_bytes()))
    scratch.unlink()


def without(name):
    return lambda file: file.__delitem__(name)


def reshaped(file):
    del file["density"]
    file["density"] = np.ones((3, 3))


def misshapen(file):
    for name in ("density", "momentum_x", "momentum_y", "energy"):
        del file[name]
        file[name] = np.ones((3, 3))


def of_version(version):
    return lambda file: file.attrs.__setitem__("format_version", version)


def of_format(file):
    file.attrs["format"] = "something else"


def timeless(file):
    del file.attrs["time"]


WRONG = {
    "a field missing": without("energy"),
    "mesh missing": without("x_faces"),
    "books missing": without("ledger"),
    "one shape wrong": reshaped,
    "all shapes wrong": misshapen,
    "next version": of_version(99),
    "version before": of_version(1),
    "format": of_format,
    "time missing": timeless,
}


@pytest.mark.parametrize("wrong", list(WRONG))
def test_a_restart_skips_a_checkpoint_with_wrong_content(wrong, copy, expected, capsys):
    path = checkpoints(copy)[-1]
    rewritten(path, WRONG[wrong])
    assert restart(copy) == 0
    assert path.name in message_of(capsys) and not differences(copy, expected)
    check_series(copy)


@pytest.mark.parametrize("entry", ["ledger/wall", "integrator/last"])
def test_a_checkpoint_without_an_entry_of_books_or_memory_is_refused(entry, copy, capsys):
    for path in checkpoints(copy):
        rewritten(path, without(entry))
    before = contents(copy)
    assert restart(copy, "time.end=3.0") == 2
    assert "does not fit" in message_of(capsys)
    assert contents(copy) == before


def test_a_file_that_is_none(copy, expected, capsys):
    """Empty, text, a folder, a link into nowhere, an HDF5 file of another program: each newer than any other."""
    place = copy / "checkpoints"
    (place / "90000000_t90.h5").write_bytes(b"")
    (place / "90000001_t91.h5").write_text("not HDF5")
    (place / "90000002_t92.h5").mkdir()
    (place / "90000003_t93.h5").symlink_to("nowhere")
    with h5py.File(place / "90000004_t94.h5", "w") as file:
        file["density"] = [1.0]
    assert restart(copy) == 0
    message = message_of(capsys)
    assert all(f"t{number}.h5" in message for number in range(90, 95))
    assert not differences(copy, expected)


def test_checkpoints_that_are_missing_are_made_again(copy, expected, undisturbed, capsys):
    """The last ones, then one in the middle, which the run does not need, then all."""
    for path in checkpoints(copy)[2:]:
        path.unlink()
    assert restart(copy) == 0 and not differences(copy, expected)
    assert times_saved(copy) == times_saved(undisturbed)
    checkpoints(copy)[1].unlink()
    assert restart(copy) == 0 and not differences(copy, expected)
    shutil.rmtree(copy / "checkpoints")
    assert restart(copy) == 0 and not differences(copy, expected)
    assert "begins anew" in message_of(capsys) and times_saved(copy) == times_saved(undisturbed)


def test_where_none_can_be_read_nothing_is_touched(copy, capsys):
    for path in checkpoints(copy):
        os.truncate(path, path.stat().st_size - 1)
    before = {path: path.read_bytes() for path in copy.rglob("*.*") if path.is_file() and path.name != ".lock"}
    assert restart(copy) == 2
    message = message_of(capsys)
    assert "none of its checkpoints can be read" in message
    assert all(path.name in message for path in checkpoints(copy))
    (copy / "deck.toml").rename(copy / "lost")
    assert restart(copy) == 2 and "none of its checkpoints can be read" in message_of(capsys)
    (copy / "lost").rename(copy / "deck.toml")
    assert {path: path.read_bytes() for path in before} == before


# Other files


def stopped(folder, number=3):
    """Take a complete run back to one of its checkpoints."""
    for path in checkpoints(folder)[number:]:
        path.unlink()


@pytest.mark.parametrize("torn", ["in a row", "in a number", "zeros", "in the header", "empty", "missing"])
def test_a_torn_history(torn, copy, expected):
    """Rows are lost only where they are later than the newest checkpoint, and come again."""
    history = copy / "history.csv"
    content = history.read_bytes()
    late = content.rindex(b"\n", 0, -1)
    stopped(copy, 3 if torn in ("in a row", "in a number", "zeros") else 0)
    match torn:
        case "in a row":
            history.write_bytes(content[: late + 40])
        case "in a number":
            history.write_bytes(content[:-5])
        case "zeros":
            history.write_bytes(content[:late] + b"\0" * 100)
        case "in the header":
            history.write_bytes(content[:30])
        case "empty":
            history.write_bytes(b"")
        case "missing":
            history.unlink()
    assert restart(copy) == 0 and not differences(copy, expected)


def test_a_header_torn_after_the_first_checkpoint(tmp_path, undisturbed):
    """A checkpoint at t = 0 is older than the first row."""
    folders = [tmp_path / name for name in ("whole", "torn")]
    words = [*deck(INTEGRATOR), "output.times=[0.0,0.2]", "time.end=0.2", "--quiet", "--output"]
    for folder in folders:
        assert main([*words, str(folder)]) == 0
    stopped(folders[1], 1)
    os.truncate(folders[1] / "history.csv", 30)
    assert restart(folders[1]) == 0 and not differences(folders[1], outcome(folders[0]))


def test_a_history_of_other_columns(copy, capsys):
    """As another version may have written: told by name, and no checkpoint is lost."""
    stopped(copy)
    history = copy / "history.csv"
    history.write_text(history.read_text().replace("time", "moment", 1))
    before = contents(copy)
    assert restart(copy) == 3 and "history.csv" in message_of(capsys)
    assert {path: path.read_bytes() for path in before} == before


def test_a_deck_that_is_lost_is_taken_from_the_checkpoint(copy, expected, undisturbed, capsys):
    stopped(copy)
    (copy / "deck.toml").unlink()
    assert restart(copy) == 0 and not differences(copy, expected)
    assert "deck in the checkpoint" in message_of(capsys)
    assert (copy / "deck.toml").read_bytes() == (undisturbed / "deck.toml").read_bytes()


def test_a_deck_that_is_torn_is_refused(copy, capsys):
    stopped(copy)
    os.truncate(copy / "deck.toml", 200)
    before = contents(copy)
    assert restart(copy) == 2 and "deck.toml" in message_of(capsys)
    assert contents(copy) == before


@pytest.mark.parametrize("content", ["", '{"completed": tr', "null", "[]", "missing"])
def test_a_torn_summary_is_written_anew(content, copy, expected):
    (copy / "summary.json").write_text(content)
    if content == "missing":
        (copy / "summary.json").unlink()
    assert restart(copy) == 0 and not differences(copy, expected)


def test_what_a_kill_leaves_half_written_is_removed(copy):
    stopped(copy)
    (copy / "frames").mkdir()
    for place in (copy, copy / "checkpoints", copy / "pictures", copy / "frames"):
        (place / f"{files.PARTIAL}abc-x").write_bytes(b"half")
    assert restart(copy) == 0
    assert not list(copy.rglob(f"{files.PARTIAL}*"))


# Two at a time

HOLDER = """
import fcntl, os, sys, time
file = open(sys.argv[1], "a+")
fcntl.flock(file, fcntl.LOCK_EX)
print(f"process {os.getpid()} on here", file=file, flush=True)
print("held", flush=True)
time.sleep(600)
"""


@pytest.fixture
def holder(copy):
    """A process that works in the folder."""
    (copy / ".lock").unlink(missing_ok=True)
    process = subprocess.Popen([sys.executable, "-c", HOLDER, copy / ".lock"], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def test_a_second_process_is_refused_and_a_killed_one_leaves_no_lock(copy, holder, expected, capsys):
    stopped(copy)
    before = contents(copy)
    commands = [["restart", str(copy)], [*deck(INTEGRATOR), "--output", str(copy), "--overwrite"]]
    for command in commands:
        assert main([*command, "--quiet"]) == 2
        assert f"process {holder.pid} on here is at work there" in message_of(capsys)
    assert contents(copy) == before
    holder.kill()
    holder.wait()
    assert restart(copy) == 0 and not differences(copy, expected)


def test_a_run_holds_the_lock_until_it_ends(tmp_path, monkeypatch):
    folder, found = tmp_path / "run", []
    write = hydro.driver.keeper.write_checkpoint

    def probe():
        with (folder / ".lock").open() as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def write_and_probe(path, saved):
        write(path, saved)
        with pytest.raises(BlockingIOError):
            probe()
        found.append((folder / ".lock").read_text())

    monkeypatch.setattr("hydro.driver.keeper.write_checkpoint", write_and_probe)
    assert main([*deck(INTEGRATOR), "--output", str(folder), "--quiet"]) == 0
    assert found and all(line == f"process {os.getpid()} on {os.uname().nodename}\n" for line in found)
    probe()
