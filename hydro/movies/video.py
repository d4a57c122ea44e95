"""Video files: H.264 in MP4, which browsers play, and GIF. Frames go to the encoder one by one."""

from __future__ import annotations

import contextlib
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO

import imageio_ffmpeg

from hydro.errors import RunFailed
from hydro.output.files import replacing

QUALITY = "18"  # constant rate factor of H.264: to the eye without loss
GIF_RATE = 12.5  # frames per second: GIF counts hundredths of a second
GIF_SIDE = 480  # pixels, the longest side


@contextlib.contextmanager
def mp4(path: Path, size: tuple[int, int], rate: int) -> Iterator[Callable[[bytes | memoryview], object]]:
    """Write a movie to `path`, whole or not at all; yields what takes its frames, RGBA bytes of (width, height).

    Width and height must be even. RunFailed when the encoder fails.
    """
    width, height = size
    raw = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    coding = ["-an", "-c:v", "libx264", "-crf", QUALITY, "-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    with replacing(path) as temporary, _encoder([*raw, *coding, str(temporary)]) as frames:
        yield frames.write


def gif(path: Path, movie: Path) -> None:
    """Write the frames of `movie` as a small GIF to `path`, whole or not at all. RunFailed when the encoder fails."""
    smaller = f"fps={GIF_RATE},scale={GIF_SIDE}:{GIF_SIDE}:force_original_aspect_ratio=decrease:flags=area"
    with replacing(path) as temporary, tempfile.TemporaryDirectory() as scratch:
        palette, source = f"{scratch}/palette.png", ["-i", str(movie)]
        for words in (
            [*source, "-vf", f"{smaller},palettegen", palette],
            [*source, "-i", palette, "-lavfi", f"{smaller}[x];[x][1:v]paletteuse=dither=none", str(temporary)],
        ):
            with _encoder(words):
                pass


@contextlib.contextmanager
def _encoder(words: Sequence[str]) -> Iterator[IO[bytes]]:
    """The input of an ffmpeg; RunFailed with its complaint if it does not end well."""
    command = [_program(), "-y", "-v", "error", *words]
    with tempfile.TemporaryFile() as complaint:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=complaint)
        assert process.stdin is not None
        try:
            with contextlib.suppress(BrokenPipeError), process.stdin:
                yield process.stdin
            process.wait()
        finally:
            process.kill()
            process.wait()
        if process.returncode:
            complaint.seek(0)
            raise RunFailed(f"the movie's encoder failed: {complaint.read().decode(errors='replace').strip()}")


def _program() -> str:
    """Where ffmpeg is; RunFailed if it is nowhere."""
    try:
        return imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise RunFailed(str(error)) from error
