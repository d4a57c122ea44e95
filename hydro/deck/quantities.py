"""Quantities with their units, as people write them: "1 mm", "50 Hz", "9.81 m/s^2"."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from pydantic.annotated_handlers import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from hydro.schema import broken_rule

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
UNIT = r"[^\W\d_]+(?:(?:\^|\*\*)-?[1-9]|[²³])?"  # a name, perhaps to a power of one digit
QUANTITY = re.compile(rf"\s*({NUMBER})\s*({UNIT}(?:\s*[ */·]\s*{UNIT})*)\s*")
SMALLEST, LARGEST = 1e-12, 1e12  # in SI units: between them no scaled number leaves the range of numbers


@dataclass(frozen=True)
class Quantity:
    """Marks a text that must be a positive quantity; `unit` is its unit in SI base units, in words of pint.

    Radians are a unit too: 50 Hz is a frequency, 314 rad/s an angular one, and neither passes for the other.
    """

    name: str
    unit: str
    example: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._check, handler(source))

    def _check(self, text: Any) -> Any:
        if text is not None:
            self.si(text)
        return text

    def si(self, text: Any) -> float:
        """The number of SI units in `text`; the error of a broken rule when it is no such quantity."""
        parts = QUANTITY.fullmatch(text) if isinstance(text, str) else None
        if parts is None:
            raise self._broken()
        import pint  # slow to import

        registry = pint.get_application_registry()
        try:
            quantity = registry.Quantity(float(parts[1]), parts[2].replace("·", "*")).to_base_units()
        except pint.UndefinedUnitError as error:
            raise self._broken(f"{error}; ") from None
        except (pint.PintError, ArithmeticError, ValueError) as error:
            raise self._broken() from error
        if quantity.units != registry.Unit(self.unit):
            raise self._broken(f"its unit is that of {quantity.units or 'a bare number'}; ")
        if not SMALLEST <= quantity.magnitude <= LARGEST:
            raise self._broken(f"must be positive, from {SMALLEST:g} to {LARGEST:g} in SI units; ")
        return float(quantity.magnitude)

    def _broken(self, problem: str = ""):
        return broken_rule(f'{problem}must be {self.name} with its unit, such as "{self.example}"')


LENGTH = Quantity("a length", "meter", "1 mm")
FREQUENCY = Quantity("a frequency", "1/second", "50 Hz")
ANGULAR_FREQUENCY = Quantity("an angular frequency", "radian/second", "314 rad/s")
ACCELERATION = Quantity("an acceleration", "meter/second**2", "9.81 m/s^2")
TEMPERATURE = Quantity("an energy per mass", "meter**2/second**2", "0.1 m^2/s^2")
