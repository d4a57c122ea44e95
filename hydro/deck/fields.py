"""What sections of decks are made of: types of values, markers of choices, and the errors of broken rules."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationInfo
from pydantic.annotated_handlers import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from hydro.registry import nearest

SMALLEST, LARGEST = 1e-30, 1e30  # sizes of numbers in decks


def broken_rule(problem: str, key: str = "", value: object = None) -> PydanticCustomError:
    """The error for a broken rule; `key` (dotted, from the top) and its `value` when another key is to blame."""
    return PydanticCustomError("rule", "{problem}", {"problem": problem, "key": key, "value": value})


def unknown_name(name: str, known: tuple[str, ...]) -> PydanticCustomError:
    """The error for a name that is not among `known`; carries the nearest one."""
    context = {"known": known, "nearest": nearest(name, known)}
    return PydanticCustomError("unknown_name", "unknown name", context)


@dataclass(frozen=True)
class Among:
    """Marks a text field that must be one of `names`."""

    names: tuple[str, ...]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        if name not in self.names:
            raise unknown_name(name, self.names)
        return name


@dataclass(frozen=True)
class OneOf:
    """Marks a tagged section: its `kind` picks the model from `table`."""

    table: Mapping[str, type[Tagged]]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {name: handler.generate_schema(model) for name, model in self.table.items()}
        tagged = core_schema.tagged_union_schema(choices, discriminator="kind")
        return core_schema.nullable_schema(tagged) if type(None) in get_args(source) else tagged


@dataclass(frozen=True)
class ListOr:
    """Marks a list that may also be given as a section from which it follows."""

    section: type[Section]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        listed, *_ = (part for part in get_args(source) if get_origin(part) is tuple)
        choices = {"list": handler.generate_schema(listed), "section": handler.generate_schema(self.section)}
        return core_schema.tagged_union_schema(choices, discriminator=self._choice)

    def _choice(self, value: Any) -> str:
        return "section" if isinstance(value, dict | self.section) else "list"


class Section(BaseModel):
    """Base of all sections: frozen, unknown keys refused, numbers finite unless a field says otherwise."""

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True, allow_inf_nan=False)


class Tagged(Section):
    """Base of sections whose `kind` picks the model."""

    kind: str


def within_reach(value: float) -> float:
    """Validates a number that formulas can multiply with others like it without leaving the floating-point numbers."""
    if value and math.isfinite(value) and not SMALLEST <= abs(value) <= LARGEST:
        raise broken_rule(f"must be zero or of a size between {SMALLEST:g} and {LARGEST:g}")
    return value


def increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    """Validates numbers of which each is greater than the one before."""
    if any(after <= before for before, after in pairwise(values)):
        raise broken_rule("must increase from item to item")
    return values


def distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Validates a list, possibly empty, without repetitions."""
    if len(set(values)) < len(values):
        raise broken_rule("must not repeat an item")
    return values


def some_distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Validates a list with an item or more, without repetitions."""
    if not values:
        raise broken_rule("must have an item")
    return distinct(values)


def file_name(name: str) -> str:
    """Validates what could be the name of a file."""
    if not name or not name.isprintable():
        raise broken_rule("must be the name of a file")
    return name


def same_length(values: tuple[float, ...], other: str, info: ValidationInfo) -> None:
    """Refuses a list that is not as long as the key `other`, declared before it."""
    expected = len(info.data.get(other, values))
    if len(values) != expected:
        raise broken_rule(f"must have as many items as {other}, {expected}")


Number = Annotated[float, Strict(), AfterValidator(within_reach)]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Density = Annotated[Number, Field(gt=0, lt=1)]
Text = Annotated[str, Strict()]
Flag = Annotated[bool, Strict()]
Axis = Annotated[Text, Among(("x", "y"))]
Cells = Annotated[int, Strict(), Field(ge=4, le=16384)]
Wave = Annotated[int, Strict(), Field(ge=0, le=16384)]
HalfWaves = Annotated[int, Strict(), Field(ge=1, le=16384)]
Axes = Annotated[tuple[Axis, ...], AfterValidator(distinct)]
Increasing = AfterValidator(increasing)
FileName = Annotated[Text, AfterValidator(file_name)]
Vector = tuple[Number, Number]
Primitive = tuple[Density, Number, Positive]


def kinds_of(model: type[Section], key: str) -> Mapping[str, type[Tagged]] | None:
    """The table of kinds when `key` of `model` is a tagged section, else None."""
    field = model.model_fields.get(key)
    markers = field.metadata if field else ()
    return next((marker.table for marker in markers if isinstance(marker, OneOf)), None)


def section_of(model: type[Section], key: str) -> type[Section] | None:
    """The model of the plain section `key` of `model`, which need not be there; None when it is no plain section."""
    field = model.model_fields.get(key)
    annotation = field.annotation if field and kinds_of(model, key) is None else None
    parts = [part for part in get_args(annotation) or (annotation,) if part is not type(None)]
    return parts[0] if len(parts) == 1 and isinstance(parts[0], type) and issubclass(parts[0], Section) else None


def list_or(model: type[Section], key: str) -> type[Section] | None:
    """The section as which `key` of `model`, else a list, may be given; None when there is none."""
    field = model.model_fields.get(key)
    return next((marker.section for marker in (field.metadata if field else ()) if isinstance(marker, ListOr)), None)


def item_of(model: type[Section], key: str) -> type[Section] | None:
    """The model of the items of `key` of `model`; None when it is no list of sections."""
    field = model.model_fields.get(key)
    parts = get_args(field.annotation) if field and get_origin(field.annotation) is tuple else ()
    return next((part for part in parts if isinstance(part, type) and issubclass(part, Section)), None)


def meaning(model: type[Section], key: str) -> str:
    """One line on `key` of `model`: its description, or that of the section that it is."""
    field = model.model_fields[key]
    return field.description or (getattr(field.annotation, "__doc__", None) or "").rstrip(".")
