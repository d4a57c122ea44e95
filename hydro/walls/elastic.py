"""The elastic wall, and what all smooth walls share."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from hydro.methods import compiled_methods
from hydro.schema import TaggedLaw


class SmoothWall:
    """A wall that no gas passes and that does not hold it back."""

    def beyond(self, n, normal, tangential, p):
        """Density, velocities across and along the wall, and pressure beyond it, for those of the cell's image."""
        return n, -normal, tangential, p


class Nothing(NamedTuple):
    """No constants; kernels want a field."""

    none: float = 0.0


@compiled_methods
class ElasticWall(Nothing, SmoothWall):
    """No heat comes from it: it has no `face`, and integrators pass it over."""

    __slots__ = ()


class Elastic(TaggedLaw):
    """Lets no heat through; also the choice where x is periodic."""

    kind: Literal["elastic"] = "elastic"

    def law(self, **given: float) -> Any:
        return ElasticWall()
