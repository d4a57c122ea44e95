"""Which law is on which side of the box."""

from __future__ import annotations

from typing import Any, NamedTuple

from hydro.walls.elastic import ElasticWall


class Walls(NamedTuple):
    """The laws of the four sides; where a direction is periodic, its two do not matter."""

    x0: Any = ElasticWall()
    x1: Any = ElasticWall()
    y0: Any = ElasticWall()
    y1: Any = ElasticWall()

    @classmethod
    def of(cls, walls: Any) -> Walls:
        """These walls; a law alone is that of the driving wall at x = 1."""
        found = walls if isinstance(walls, Walls) else cls(x1=walls)
        for side, law in zip(cls._fields, found, strict=True):
            if isinstance(law, type):
                raise TypeError(f"the wall {side} is the class {law.__name__}; give a law, {law.__name__}(...)")
        return found
