"""Video files: H.264 in MP4, which browsers play, and GIF. Frames go to the encoder one by one."""

from __future__ import annotations

import contextlib
import re
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import imageio.v3 as imageio
import numpy as np

from hydro.errors import RunFailed
from hydro.output.files import replacing

QUALITY = 6.4  # of 10. It makes the constant rate factor of H.264 18: to the eye without loss
GIF_RATE = 12.5  # frames per second: GIF counts hundredths of a second
GIF_SIDE = 480  # pixels, the longest side
GIF_END = b";"  # the last byte of a whole one
# Shrunk in the colours of H.264, in which even areas stay even, pictures take less room.
SMALLER = f"format=yuv420p,fps={GIF_RATE},scale={GIF_SIDE}:{GIF_SIDE}:force_original_aspect_ratio=decrease:flags=area"


def mp4(path: Path, frames: Iterable[np.ndarray], rate: int) -> None:
    """Write frames, RGBA bytes of shape (height, width, 4), as a movie of `rate` a second, whole or not at all.

    Width and height must be even. RunFailed when the encoder fails.
    """
    given = 0

    def counting() -> Iterator[np.ndarray]:
        nonlocal given
        for frame in frames:
            given += 1
            yield frame

    coding = {"codec": "libx264", "quality": QUALITY, "pixelformat": "yuv420p"}
    with replacing(path) as temporary, _encoder_may_fail():
        _encode(temporary, counting(), rate, output_params=["-movflags", "+faststart"], **coding)
        if (kept := sum(1 for _ in _frames_of(temporary))) != given:
            raise RuntimeError(f"{kept} frames of {given} are in the file")


def gif(path: Path, movie: Path, rate: int) -> None:
    """Write the frames of `movie`, `rate` a second, as a small GIF to `path`, whole or not at all.

    RunFailed when the encoder fails.
    """
    with replacing(path) as temporary, tempfile.TemporaryDirectory() as scratch, _encoder_may_fail():
        palette = Path(scratch, "palette.png")
        colours = ["-vf", f"{SMALLER},palettegen", "-update", "1"]
        _encode(palette, _frames_of(movie), rate, codec="png", pixelformat="rgba", output_params=colours)
        drawing = f"movie={_in_filter(palette)}[colours];[0:v]{SMALLER}[small];[small][colours]paletteuse=dither=none"
        _encode(temporary, _frames_of(movie), rate, codec="gif", pixelformat="pal8", output_params=["-lavfi", drawing])
        if not temporary.read_bytes().endswith(GIF_END):
            raise RuntimeError("the GIF has no end")


def _encode(path: Path, frames: Iterable[np.ndarray], rate: int, **options: Any) -> None:
    """Have ffmpeg write frames; OSError if it does not take them all. What it complains of is on stderr."""
    imageio.imwrite(
        path, cast(Any, frames), plugin="FFMPEG", extension=".mp4", is_batch=True, fps=rate, macro_block_size=1,
        ffmpeg_log_level="error", **options,
    )  # fmt: skip


def _frames_of(movie: Path) -> Iterator[np.ndarray]:
    """The frames of a movie, RGB bytes of shape (height, width, 3), one by one."""
    return imageio.imiter(movie, plugin="FFMPEG")


@contextlib.contextmanager
def _encoder_may_fail() -> Iterator[None]:
    """RunFailed in place of what imageio raises."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        raise RunFailed(f"the movie's encoder failed: {str(error).strip().partition(chr(10))[0]}") from error


def _in_filter(path: Path) -> str:
    """A path as ffmpeg reads it in a description of filters: as the value of an option, and that as a part of it."""
    return re.sub(r"([\\'\[\],;])", r"\\\1", re.sub(r"([\\':])", r"\\\1", str(path)))
