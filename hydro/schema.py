"""What sections of decks are made of: types of values, choices, and the errors of broken rules.

A section stands beside what it is for, a wall law or an initial state, and is a model of its keys.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, get_args, get_origin, get_type_hints

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PydanticUserError,
    Strict,
    ValidationInfo,
    create_model,
)
from pydantic.annotated_handlers import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from hydro.own import Unusable
from hydro.registry import Registry

SMALLEST, LARGEST = 1e-30, 1e30  # sizes of numbers in decks


def broken_rule(problem: str, key: str = "", value: object = None) -> PydanticCustomError:
    """The error for a broken rule; `key` (dotted, from the top) and its `value` when another key is to blame."""
    return PydanticCustomError("rule", "{problem}", {"problem": problem, "key": key, "value": value})


def unknown_choice(value: object, known: Iterable[str], key: str = "", problem: str = "") -> PydanticCustomError:
    """The error for a value that is not among known names; `key` when it stands below the section that is to blame.

    problem: what is wrong with it where it is the part of a user's own.
    """
    context = {"value": value, "known": tuple(known), "key": key, "problem": problem}
    return PydanticCustomError("unknown_choice", "unknown choice", context)


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
Axis = Literal["x", "y"]
Cells = Annotated[int, Strict(), Field(ge=4, le=16384)]
Wave = Annotated[int, Strict(), Field(ge=0, le=16384)]
HalfWaves = Annotated[int, Strict(), Field(ge=1, le=16384)]
Axes = Annotated[tuple[Axis, ...], AfterValidator(distinct)]
Increasing = AfterValidator(increasing)
FileName = Annotated[Text, AfterValidator(file_name)]
Vector = tuple[Number, Number]
Primitive = tuple[Density, Number, Positive]
PLAIN: dict[Any, Any] = {float: Number, int: Annotated[int, Strict()], bool: Flag}  # what plain types stand for


@dataclass(frozen=True)
class Named:
    """Marks a text that must be a name in `table`."""

    table: Registry[Any]
    only: tuple[str, ...] | None = None  # of the names; all, and parts of a user's own, when not given

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.found, handler(source))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the table that are allowed."""
        return tuple(self.table) if self.only is None else self.only

    def found(self, name: Any, key: str = "") -> str:
        """The name, if it may be used; else the error for that, at a `key`."""
        if isinstance(name, str) and self.only is None and self.table.admits(name):
            try:
                self._loaded(name)
            except Unusable as error:
                raise unknown_choice(name, self.names, key, str(error)) from None
            return name
        if not isinstance(name, str) or name not in self.names:
            raise unknown_choice(name, self.names, key)
        return name

    def _loaded(self, name: str) -> Any:
        return self.table[name]


@dataclass(frozen=True)
class Chosen(Named):
    """Marks a section of which one key says by name what it is: its model is what the table has beside that name.

    A part that is no section itself gets one: the keys of `shared`, and the fields of its NamedTuple.
    """

    key: str = "kind"
    shared: type[Law] | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        chosen = core_schema.no_info_plain_validator_function(self._validated)
        return core_schema.nullable_schema(chosen) if type(None) in get_args(source) else chosen

    def _validated(self, value: Any) -> Section:
        if isinstance(value, Section):
            return value
        if not isinstance(value, dict):
            raise PydanticCustomError("model_type", "no section")
        return self.model(self.found(self.name_in(value), self.key)).model_validate(value)

    def name_in(self, section: Mapping[str, Any]) -> Any:
        """What a section says of what it is, or leaves to be understood."""
        field = None if self.shared is None else self.shared.model_fields[self.key]
        default = None if field is None or field.is_required() else field.default
        return section.get(self.key, default)

    def model(self, name: str) -> type[Section]:
        """The model of the section of what a name stands for; Unusable if that has none."""
        part = self.table.section(name)
        if issubclass(part, Section):
            return part
        assert self.shared is not None
        return section_of_fields(part, self.shared)

    def _loaded(self, name: str) -> Any:
        return self.model(name)

    def model_in(self, section: Any) -> type[Section] | None:
        """The model that a section, as a deck has it, asks for; None if it asks for none that is known."""
        try:
            return self.model(self.found(self.name_in(section), self.key)) if isinstance(section, dict) else None
        except PydanticCustomError:
            return None

    @property
    def models(self) -> dict[str, type[Section]]:
        """The models of all names."""
        return {name: self.model(name) for name in self.names}


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
    """Base of sections of which `kind` says what they are."""

    kind: Text


class Law(Section):
    """Base of sections that give a law its numbers: the fields of the NamedTuple `made`, by name."""

    made: ClassVar[Any] = None
    elsewhere: ClassVar[tuple[str, ...]] = ()  # fields that are no keys of the section

    def law(self, **given: float) -> Any:
        """The law, with the numbers given instead of the section's own; NaN where that has none."""
        numbers = {name: given[name] if name in given else getattr(self, name) for name in self.made._fields}
        return self.made(**{name: math.nan if number is None else number for name, number in numbers.items()})


class TaggedLaw(Tagged, Law):
    """Base of sections of laws of which `kind` says what they are; K is that of the gas."""

    elsewhere: ClassVar[tuple[str, ...]] = ("K",)


@cache
def section_of_fields(law: Any, shared: type[Law]) -> type[Section]:
    """The section of a law that is a NamedTuple: the keys of `shared`, and the fields that these do not give.

    Unusable where a field cannot be a key.
    """
    types = get_type_hints(law, include_extras=True)
    keys: dict[str, Any] = {}
    for name in law._fields:
        provided = {*shared.model_fields, *shared.elsewhere}
        if name in provided or isinstance(getattr(shared, name, None), property):
            continue
        if hasattr(shared, name):
            raise Unusable(f"the field {name} of {law.__name__} needs another name: sections have that already")
        keys[name] = (PLAIN.get(types[name], types[name]), law._field_defaults.get(name, ...))
    try:
        model: type[Law] = create_model(law.__name__, __base__=shared, __doc__=law.__doc__, **keys)
    except PydanticUserError:
        raise Unusable(
            f"the fields of {law.__name__} must be of type float, int or bool, or of one of hydro.schema"
        ) from None
    model.made = law
    return model


def choice_of(model: type[Section], key: str) -> Chosen | None:
    """The choice that the section `key` of `model` depends on; None when it depends on none."""
    field = model.model_fields.get(key)
    return next((marker for marker in (field.metadata if field else ()) if isinstance(marker, Chosen)), None)


def model_in(model: type[Section], key: str, section: Any) -> type[Section] | None:
    """The model of the section `key` of `model`, as the `section` itself has chosen it; None where there is none."""
    choice = choice_of(model, key)
    return section_of(model, key) if choice is None else choice.model_in(section)


def section_of(model: type[Section], key: str) -> type[Section] | None:
    """The model of the plain section `key` of `model`, which need not be there; None when it is no plain section."""
    field = model.model_fields.get(key)
    annotation = field.annotation if field and choice_of(model, key) is None else None
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
    section = isinstance(field.annotation, type) and issubclass(field.annotation, Section)
    return field.description or ((field.annotation.__doc__ or "").rstrip(".") if section else "")
