"""A table of a scenario: read from a file, or filled in Python as an instance of its class."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, TypeVar, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, PrivateAttr, ValidationError

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.scenario.sentences import keys_of, refusal

_Read = TypeVar("_Read", covariant=True)
_Written = TypeVar("_Written", contravariant=True)

if TYPE_CHECKING:

    class Given(Generic[_Read, _Written]):
        """The type of a value that is written otherwise than it is read: "35 mm" and 0.035."""

        def __get__(self, instance: object, owner: Any) -> _Read: ...

        def __set__(self, instance: object, value: _Written) -> None: ...

    from pydantic._internal._model_construction import ModelMetaclass as TableType
else:

    class Given:
        """See above; what pydantic sees is the type that is read."""

        def __class_getitem__(cls, types: tuple[Any, Any]) -> Any:
            return types[0]

    class TableType(type(BaseModel)):
        """Makes a table from values given in Python. Pydantic makes those of a file without it."""

        def __call__(cls, **values: Any) -> Table:
            """The table, which remembers what was given.

            Raises:
                ScenarioError: a key is unknown or missing, or a value is not allowed.
            """
            keys = {name: key for key, name in keys_of(cls).items()}
            for name, value in values.items():
                if isinstance(value, Table) and _holds_several(cls, name):
                    one = type(value).title()
                    raise ScenarioError(f"{cls.title()}: {name} is one {one}; write a list, {name}=[{one}(...)]")
            given = cls.tags() | {keys.get(name, name): value for name, value in values.items() if value is not None}
            try:
                table = super().__call__(**{key: plain(value, tables=False) for key, value in given.items()})
            except ValidationError as error:
                named = plain(given).get("name")
                label = cls.title() + (f" {as_written(named)}" if isinstance(named, str) else "")
                raise refusal(error, label, cls) from None
            table._given = plain(given, tables=False)
            return table


def _holds_several(model: type[BaseModel], name: str) -> bool:
    """Whether a key of a table holds a list."""
    annotation = model.model_fields[name].annotation if name in model.model_fields else None
    return any(get_origin(one) in (list, tuple) for one in (annotation, *get_args(annotation)))


Values = Sequence[float | str] | np.ndarray
"""Several numbers or texts."""
Points = Sequence[Values] | np.ndarray
Quantity = Given[float, float | str]
"""A number in SI units, or text with a unit."""
Quantities = Given[tuple[float, ...], Values]
QuantityOrList = Given[float | tuple[float, ...], float | str | Values]
OptionalQuantity = Given[float | None, float | str | None]
OptionalQuantities = Given[tuple[float, ...] | None, Values | None]
OptionalQuantityOrList = Given[float | tuple[float, ...] | None, float | str | Values | None]


def default(value: Any) -> Any:
    """The default of a key, as it is read."""
    return value


def tag() -> Any:
    """The key by which the members of a union are told apart: each class has its own, a file states it."""
    return ...


class Table(BaseModel, metaclass=TableType):
    """A table of a scenario: unknown keys are refused, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    _given: dict[str, Any] | None = PrivateAttr(None)

    @classmethod
    def title(cls) -> str:
        """The name of the class as a user writes it."""
        return cls.__name__.removesuffix("Table")

    @classmethod
    def tags(cls) -> dict[str, str]:
        """The keys that tell the class from others of its union, with their values."""
        choices = {key: get_args(field.annotation) for key, field in cls.model_fields.items() if field.is_required()}
        return {key: values[0] for key, values in choices.items() if len(values) == 1 and isinstance(values[0], str)}

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        yield from super().__repr_args__() if self._given is None else self._given.items()

    def __repr_name__(self) -> str:
        return self.title()

    def __str__(self) -> str:
        return repr(self)


def plain(value: Any, *, tables: bool = True) -> Any:
    """A deep copy of strings, numbers, lists and tables, as TOML has them; keys without a value are left out.

    What no file can hold stays as it is, for the reader to refuse.

    Args:
        value: to copy.
        tables: whether an instance of `Table` becomes its keys and values as they were given.
    """
    if isinstance(value, Table):
        if not tables:
            return value
        return value.model_dump(by_alias=True, exclude_unset=True) if value._given is None else plain(value._given)
    if isinstance(value, Mapping):
        return {key: plain(entry, tables=tables) for key, entry in value.items() if entry is not None}
    if isinstance(value, list | tuple):
        return [plain(entry, tables=tables) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value
