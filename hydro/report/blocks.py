"""What a page is made of. The template draws each block by its `kind`."""

from __future__ import annotations

import base64
import io
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

DOTS_PER_INCH = 160  # of the pictures of runs, as hydro.pictures.style says
PIXELS_PER_INCH = 96  # of a page
WIDE = 5.5  # inches: wider pictures are not shrunk to a narrow screen but scrolled, to stay readable
NO_BREAK = "\u00a0"  # a space at which lines do not end
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Figure:
    """A picture; source: data URI of a PNG, width and height: in pixels of the page."""

    kind: ClassVar[str] = "figure"
    source: str
    width: int
    height: int
    alt: str
    caption: str = ""

    @property
    def wide(self) -> bool:
        return self.width > WIDE * PIXELS_PER_INCH


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side."""

    kind: ClassVar[str] = "gallery"
    figures: Sequence[Figure]


@dataclass(frozen=True)
class Video:
    """A movie; source: data URI."""

    kind: ClassVar[str] = "video"
    source: str
    label: str


@dataclass(frozen=True)
class Table:
    """Rows of cells, text or numbers.

    folded: shown when asked for. stacked: on a narrow screen the last column goes below the others.
    """

    kind: ClassVar[str] = "table"
    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[Any]]
    folded: bool = False
    stacked: bool = False


@dataclass(frozen=True)
class Facts:
    """A few names with their values."""

    kind: ClassVar[str] = "facts"
    pairs: Sequence[tuple[str, Any]]


@dataclass(frozen=True)
class Lines:
    """Short sentences; warning: whether they ask for attention."""

    kind: ClassVar[str] = "lines"
    items: Sequence[str]
    warning: bool = False


@dataclass(frozen=True)
class Code:
    """Text of a file."""

    kind: ClassVar[str] = "code"
    text: str


Block = Figure | Gallery | Video | Table | Facts | Lines | Code


@dataclass(frozen=True)
class Section:
    """A part of the page under a heading."""

    title: str
    blocks: Sequence[Block]


def number(value: Any, digits: int = 4) -> str:
    """A value for print: a few digits, powers of ten written out, a dash for what is not there."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, float):
        return str(value)
    factor, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"{NO_BREAK}×{NO_BREAK}10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return factor.replace("-", "−") + power


def picture(path: Path, alt: str, caption: str = "") -> Figure:
    """A PNG file."""
    return _figure(path.read_bytes(), alt, caption)


def drawing(figure: Any, alt: str, caption: str = "") -> Figure:
    """A figure of matplotlib."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH, bbox_inches="tight")
    return _figure(buffer.getvalue(), alt, caption)


def _figure(png: bytes, alt: str, caption: str) -> Figure:
    width, height = (round(size * PIXELS_PER_INCH / DOTS_PER_INCH) for size in struct.unpack(">II", png[16:24]))
    return Figure(data_uri("image/png", png), width, height, alt, caption)


def data_uri(media_type: str, content: bytes) -> str:
    """The content of a file as an address."""
    return f"data:{media_type};base64,{base64.b64encode(content).decode('ascii')}"
