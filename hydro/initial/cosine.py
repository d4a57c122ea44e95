"""A density that varies like a cosine across the box."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from hydro.initial.state import Pattern, Patterned
from hydro.mesh import Mesh
from hydro.schema import Number, Wave


class CosinePattern(Pattern):
    """n is multiplied by 1 + amplitude cos(pi wave y/aspect_ratio)."""

    kind: Literal["cosine"] = "cosine"
    amplitude: Number = Field(default=0.1, gt=-1, lt=1, description="relative amplitude")
    wave: Wave = Field(default=1, description="number of half-waves across the box in y")

    @property
    def largest(self) -> float:
        return abs(self.amplitude)

    def values(self, mesh: Mesh) -> np.ndarray:
        return np.broadcast_to(self.amplitude * cosine_averages(mesh, self.wave), mesh.cells)


class Cosine(CosinePattern, Patterned):
    """At rest, n = f (1 + amplitude cos(pi wave y/aspect_ratio))."""


def cosine_averages(mesh: Mesh, wave: int) -> np.ndarray:
    """Cell averages of cos(pi wave y/aspect_ratio), shape (ny,): even or odd about the middle, to the last bit."""
    if wave == 0:
        return np.ones_like(mesh.dy)
    k = np.pi * wave / mesh.aspect_ratio
    averages = np.diff(np.sin(k * mesh.y_faces)) / (k * mesh.dy)
    return 0.5 * (averages + (-1.0) ** wave * averages[::-1])


def sine_averages(mesh: Mesh, wave: int) -> np.ndarray:
    """Cell averages of sin(pi wave y/aspect_ratio), shape (ny,)."""
    if wave == 0:
        return np.zeros_like(mesh.dy)
    k = np.pi * wave / mesh.aspect_ratio
    return -np.diff(np.cos(k * mesh.y_faces)) / (k * mesh.dy)
