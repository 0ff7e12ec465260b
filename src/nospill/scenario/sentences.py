"""From what pydantic found in a table to sentences with the value and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, PydanticCustomError

from nospill.core.suggestions import nearest
from nospill.core.units import as_written, listed
from nospill.errors import Reason, ScenarioError
from nospill.scenario.other_names import meant

SENTENCE = "nospill_sentence"
"""Type of the pydantic errors that carry a finished sentence (value first, then what is allowed) in their context."""

Fault = tuple[str, str]
"""Place in the file ("[tray]", 'cargo "c2"' or "" for the top level), and what is wrong there."""

Location = tuple[int | str, ...]
"""Where pydantic found an error: keys, indices and, behind a union, the tag of its member."""


def refuse(sentence: str) -> PydanticCustomError:
    """The error a field raises: a sentence that starts with the value; the key is put before it when it is reported."""
    return PydanticCustomError(SENTENCE, "{sentence}", {"sentence": sentence})


def report(label: str, faults: Sequence[Fault], reason: Reason | None = None) -> ScenarioError:
    """The error for a scenario called `label` (its file as the user named it): the first fault, and how many more.

    With a reason, which is the first fault's, the message names the smallest change that helps.
    """
    place, text = faults[0]
    if reason is not None and reason.changes:
        text += f", for example {reason.changes[0].text}"
    line = ": ".join(part for part in (label, place, text) if part) + _more(faults[1:])
    return ScenarioError(" ".join(line.splitlines()), reason)


def refusal(error: ValidationError, label: str, model: type[BaseModel]) -> ScenarioError:
    """The error for one table that was filled in Python."""
    faults: list[Fault] = []
    for detail in details_of(error):
        place, keys, inner = "", detail["loc"], model
        while len(keys) > 1 and (below := model_of(inner, str(keys[0]))) is not None:
            place, keys, inner = f"{place}.{keys[0]}".lstrip("."), keys[1:], below
        # inside a list, pydantic names the member of a union, not its class
        known = inner if len(keys) == 1 else None
        faults.append((place, sentence(detail, keys, known, subject=key_path(keys))))
    return report(label, faults)


def details_of(error: ValidationError) -> list[ErrorDetails]:
    """Every error, unknown keys first; that a misspelt key is missing under its right name is no error of its own."""
    found = error.errors(include_url=False)
    missing = {detail["loc"] for detail in found if detail["type"] == "missing"}
    unknown = [detail["loc"] for detail in found if detail["type"] == "extra_forbidden"]
    for place in unknown:
        siblings = [str(other[-1]) for other in missing if other[:-1] == place[:-1]]
        missing.discard((*place[:-1], nearest(str(place[-1]), siblings, likeness=0.7) or ""))
    kept = [detail for detail in found if detail["type"] != "missing" or detail["loc"] in missing]
    return sorted(kept, key=lambda detail: detail["type"] != "extra_forbidden")


def sentence(
    detail: ErrorDetails,
    keys: Location,
    model: type[BaseModel] | None,
    *,
    subject: str,
    owner: Callable[[str], str | None] = lambda key: None,
) -> str:
    """What is wrong, from the key on.

    Args:
        detail: as pydantic reports it.
        keys: below the table, without the tags of unions.
        model: the table whose keys are allowed there.
        subject: how the value is called.
        owner: an unknown key -> another table that has it.
    """
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    shown = as_written(value)
    if kind == "missing":
        return f"{subject} is missing: {_description(model, keys)}"
    if kind == "extra_forbidden":
        return _unknown_key(keys, model, owner)
    if kind == SENTENCE:
        return f"{subject} {context['sentence']}"
    if kind in ("model_type", "model_attributes_type"):
        inner = model_of(model, str(keys[-1])) if model is not None and keys else None
        keys_of_it = (
            f"{{ {', '.join(f'{key} = ...' for key in keys_of(inner))} }}" if inner is not None else "in braces"
        )
        in_python = f", in Python {inner.__name__.removesuffix('Table')}(...)" if inner is not None else ""
        return (
            f"{subject} is not a table but {shown}; write its keys {keys_of_it} or under their own heading{in_python}"
        )
    if kind in _SENTENCES:
        return f"{subject} {_SENTENCES[kind](shown, context)}"
    return f"{subject} {shown} is not accepted here ({kind})"


def model_of(model: type[BaseModel], key: str) -> type[BaseModel] | None:
    """The table that a key of another one holds; None for any other value."""
    annotation = model.model_fields[key].annotation if key in model.model_fields else None
    # an optional table is a union of it and None
    choices = get_args(annotation) or (annotation,)
    return next((item for item in choices if isinstance(item, type) and issubclass(item, BaseModel)), None)


def keys_of(model: type[BaseModel]) -> dict[str, str]:
    """The keys of a table as they stand in the file, with their names in Python."""
    return {info.alias or name: name for name, info in model.model_fields.items()}


def key_path(keys: Location) -> str:
    """Keys as one text."""
    text = ""
    for key in keys:
        text += f" entry {key + 1}" if isinstance(key, int) else f".{key}" if text else key
    return text


def _more(others: Sequence[Fault]) -> str:
    """How many more mistakes there are, and where."""
    if not others:
        return ""
    where = list(dict.fromkeys(place for place, _ in others if place))
    count = f"{len(others)} more mistake{'s' if len(others) > 1 else ''}"
    return f" (and {count} in {listed(where, last='and')})" if where else f" (and {count})"


def _one_of(choices: str) -> str:
    """`'a', 'b' or 'c'` as pydantic lists them, in the quotes of TOML."""
    return choices.replace("'", '"')


def _not_one_of(shown: str, choices: str) -> str:
    expected = _one_of(choices)
    near = nearest(shown, re.findall(r'"[^"]*"', expected), likeness=0.7)
    return f"{shown} is not one of {expected}" + (f"; did you mean {near}?" if near else "")


def _entries(context: Mapping[str, Any]) -> str:
    least, given = context["min_length"], context["actual_length"]
    needed = "1 is needed" if least == 1 else f"{least} are needed"
    return f"has {given or 'no'} {'entry' if given == 1 else 'entries'}; at least {needed}"


def _too_many(context: Mapping[str, Any]) -> str:
    return f"has more than {context['max_length']} entries; at most {context['max_length']} are planned for"


def _tag(context: Mapping[str, Any]) -> str:
    key, choices = context["discriminator"].strip("'"), re.findall(r"'([^']*)'", context["expected_tags"])
    near = nearest(str(context["tag"]), choices)
    hint = f'; did you mean "{near}"?' if near else ""
    return f"has the unknown {key} {as_written(context['tag'])}; choose one of {_quote(choices)}{hint}"


def _quote(choices: Iterable[str]) -> str:
    return listed([as_written(choice) for choice in choices])


_SENTENCES: dict[str, Callable[[str, Mapping[str, Any]], str]] = {
    "literal_error": lambda shown, context: _not_one_of(shown, context["expected"]),
    "string_type": lambda shown, context: f"{shown} is not text; put it in quotes",
    "bool_type": lambda shown, context: f"{shown} is neither true nor false; write one of them without quotes",
    "int_type": lambda shown, context: f"{shown} is not a whole number; write one without quotes or decimal point",
    "greater_than_equal": lambda shown, context: f"{shown} is out of range: it must be at least {context['ge']}",
    "less_than_equal": lambda shown, context: f"{shown} is out of range: it must be at most {context['le']}",
    "dict_type": lambda shown, context: f"{shown} is not a table; write {{ name = value }}",
    "list_type": lambda shown, context: f"{shown} is not a list; put the values in brackets",
    "too_short": lambda shown, context: _entries(context),
    "too_long": lambda shown, context: _too_many(context),
    "union_tag_invalid": lambda shown, context: _tag(context),
}
"""Pydantic's error type -> what follows the key in the message."""


def _description(model: type[BaseModel] | None, keys: Location) -> str:
    field = None if model is None else _field(model, str(keys[-1]))
    return (field.description if field else None) or "it has to be given"


def _field(model: type[BaseModel], key: str) -> FieldInfo | None:
    name = keys_of(model).get(key)
    return None if name is None else model.model_fields[name]


def _unknown_key(keys: Location, model: type[BaseModel] | None, owner: Callable[[str], str | None]) -> str:
    key = str(keys[-1])
    allowed = list(keys_of(model)) if model else []
    text = f"unknown key {as_written(key)}" + (f" in {key_path(keys[:-1])}" if len(keys) > 1 else "")
    other = meant(key, allowed)
    if other:
        return f"{text}; {other}"
    near = nearest(key, allowed, likeness=0.7)
    if near:
        return f'{text}; did you mean "{near}"?'
    elsewhere = owner(key)
    hint = f"; it belongs to [{elsewhere}]" if elsewhere else ""
    return f"{text}{hint}; allowed here: {', '.join(allowed)}" if allowed else text + hint
