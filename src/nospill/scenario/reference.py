"""The page of all keys of a scenario file, walked out of the JSON schema: type, unit, default, bounds and meaning."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from nospill.core.units import DIMENSIONS
from nospill.scenario.scenes import scenario_schema

Schema = dict[str, Any]

_UNITS = re.compile(r"\\s\*\(([^()]*)\)\??\\s\*\$$")
_LARGE_ANGLE = 50.0
"""rad; bounds beyond it are no angles people think of in degrees."""


@dataclass(frozen=True, slots=True)
class Section:
    """One table of the file.

    Attributes:
        place: as it stands in a file, with what selects it (`[path]` with `type = "line"`).
        description: from the schema.
        rows: key -> its schema. required: keys without a default.
    """

    place: str
    description: str
    rows: dict[str, Schema]
    required: frozenset[str]


INTRODUCTION = """# Keys of a scenario

Every key of a scenario file, generated from the reader's own tables by `nospill schema --markdown`.
[The scenario guide](scenario-guide.md) introduces the keys by hand.
Unknown keys are refused.
A quantity is a string with one of its units, or a bare number in the first of them.
A bare number that is hardly meant in that unit, such as a radius of 35, is refused.
A dash as default means that the meaning states what applies where the key is absent.
"""


def scenario_page() -> str:
    """The page of all keys as Markdown."""
    return INTRODUCTION + scenario_reference()


def scenario_reference() -> str:
    """The whole reference as Markdown, one heading a table of the file."""
    schema = scenario_schema()
    return "".join(_section_text(section, schema) for section in sections(schema))


def sections(schema: Schema) -> Iterator[Section]:
    """The tables of a scenario file, the top level first, in the order of the schema."""
    yield _section("top level", schema)
    for key, value in schema["properties"].items():
        yield from _tables(key, value, schema)


def _tables(key: str, value: Schema, schema: Schema) -> Iterator[Section]:
    """Sections for everything below one key: tables, lists of tables, unions of either."""
    variants = list(_members(value, schema))
    objects = [item for item in variants if item.get("properties")]
    lists = [item for item in variants if item.get("type") == "array"]
    brackets = f"[{key}]"
    for item in lists:
        inner = [entry for entry in _members(item.get("items", {}), schema) if entry.get("properties")]
        if inner:
            objects, brackets = inner, f"[[{key}]]"
    if not objects:
        return
    if len(objects) == 1:
        yield _section(f"`{brackets}`", objects[0])
    else:
        yield from _union(brackets, objects)
    seen: set[str] = set()
    for item in objects:
        for name, below in item["properties"].items():
            if name not in seen and any(True for _ in _tables(name, below, schema)):
                seen.add(name)
                yield from _tables(f"{key}.{name}", below, schema)


def _union(brackets: str, objects: list[Schema]) -> Iterator[Section]:
    """Keys that all members share, once; then the own keys of each."""
    first, *others = (item["properties"] for item in objects)
    shared = {name: value for name, value in first.items() if all(other.get(name) == value for other in others)}
    required = frozenset.intersection(*(frozenset(item.get("required", ())) for item in objects))
    if shared:
        yield Section(f"Every `{brackets}`", "", shared, required)
    for item in objects:
        of_kind = {name: value for name, value in item["properties"].items() if name not in shared}
        tags = [f'`{name} = "{value["const"]}"`' for name, value in of_kind.items() if "const" in value]
        yield Section(
            f"`{brackets}` with {', '.join(tags)}" if tags else f"`{brackets}`: {item.get('title', '')}",
            item.get("description", ""),
            of_kind,
            frozenset(item.get("required", ())),
        )


def _section(place: str, item: Schema) -> Section:
    return Section(place, item.get("description", ""), item["properties"], frozenset(item.get("required", ())))


def _members(value: Schema, schema: Schema) -> Iterator[Schema]:
    """The alternatives of a value, references followed; nothing stands for itself."""
    if "$ref" in value:
        yield from _members(schema["$defs"][value["$ref"].rsplit("/", 1)[1]], schema)
    elif "anyOf" in value or "oneOf" in value:
        for item in value.get("anyOf", value.get("oneOf", [])):
            yield from _members(item, schema)
    elif value.get("type") != "null":
        yield value


def _section_text(section: Section, schema: Schema) -> str:
    head = "## The top level" if section.place == "top level" else f"## {section.place}"
    about = re.sub(r"^`\[+[\w.]+\]+`(?: with [^:]*)?: ?|^`type = [^`]*`: ?", "", section.description)
    intro = f"{about[:1].upper()}{about[1:]}\n\n" if about else ""
    lines = ["| key | type and units | default | allowed | meaning |", "|---|---|---|---|---|"]
    for name, value in section.rows.items():
        meaning = value.get("description", "selects these keys" if "const" in value else "")
        cells = (
            f"`{name}`",
            type_text(value, schema),
            default_text(name, value, section.required),
            "; ".join(dict.fromkeys(bounds_text(value, schema))),
            meaning,
        )
        lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return f"\n{head}\n\n{intro}" + "\n".join(lines) + "\n"


def type_text(value: Schema, schema: Schema) -> str:
    """What may stand there, in words, with the units it takes (the first is the one a bare number is in)."""
    kinds: list[str] = []
    members = list(_members(value, schema))
    quantities = [item for item in members if _units(item) is not None]
    for item in members:
        if item.get("type") == "number" and quantities:
            continue  # the bare number of a quantity
        kinds.append(_kind(item, schema))
    return " or ".join(dict.fromkeys(kinds))


def _kind(item: Schema, schema: Schema) -> str:
    if "const" in item:
        return f"`{json.dumps(item['const'])}`"
    if "enum" in item:
        return ", ".join(f"`{json.dumps(choice)}`" for choice in item["enum"])
    units = _units(item)
    if units is not None:
        return _quantity(units)
    if item.get("type") == "array":
        least, most = item.get("minItems"), item.get("maxItems")
        count = f"{least} values" if least == most and least else f"at least {least}" if least else "any length"
        return f"list of {count}, each {type_text(item.get('items', {}), schema)}"
    if isinstance(item.get("additionalProperties"), dict):
        return f"table of names, each {type_text(item['additionalProperties'], schema)}"
    if item.get("properties"):
        return "table"
    words = {
        "string": "text",
        "integer": "whole number",
        "number": "number",
        "boolean": "true or false",
        "object": "table",
    }
    return words.get(str(item.get("type")), str(item.get("type", "anything")))


def _units(item: Schema) -> tuple[str, ...] | None:
    """Units of a quantity, from the pattern of its text; None for what is no quantity."""
    pattern = item.get("pattern", "")
    if item.get("type") != "string" or not pattern.startswith(r"^\s*[+-]?"):
        return None
    found = _UNITS.search(pattern)
    return tuple(re.sub(r"\\(.)", r"\1", unit) for unit in found.group(1).split("|")) if found else ()


def _quantity(units: tuple[str, ...]) -> str:
    titles = [kind.title for kind in DIMENSIONS.values() if tuple(unit for unit in kind.units if unit) == units]
    if not units:
        return "number"
    if units[0] == "%":
        return "ratio (a bare number, or %)"
    return f"{titles[0].split(' ', 1)[1]} ({', '.join(units)})"


def bounds_text(value: Schema, schema: Schema) -> Iterator[str]:
    """The bounds of a value in words, in the unit people use."""
    members = list(_members(value, schema))
    units = next((found for found in map(_units, members) if found is not None), None)
    for item in members:
        if item.get("type") == "array":
            yield from bounds_text(item.get("items", {}), schema)
            continue
        words = {
            "above": item.get("exclusiveMinimum"),
            "at least": item.get("minimum"),
            "below": item.get("exclusiveMaximum"),
            "at most": item.get("maximum"),
        }
        text = ", ".join(f"{word} {_value_text(bound, units)}" for word, bound in words.items() if bound is not None)
        if text:
            yield text
        if "maxLength" in item:
            yield f"at most {item['maxLength']} letters"
        if item.get("type") == "string" and "pattern" in item and _units(item) is None:
            yield "1 to 64 letters, digits, - and _" if "{1,64}" in item["pattern"] else f"`{item['pattern']}`"


def _value_text(number: float, units: tuple[str, ...] | None) -> str:
    if not units or units[0] == "%":  # a bare ratio is a fraction
        return f"{number:g}"
    if units[0] == "rad" and abs(number) < _LARGE_ANGLE:
        return f"{number * 57.29577951308232:.6g} deg"
    if units[0] == "m" and 0 < abs(number) < 0.01:
        return f"{1e3 * number:g} mm"
    return f"{number:g} {units[0]}"


def default_text(name: str, value: Schema, required: frozenset[str]) -> str:
    """The default as it would be written, "required", or a dash where leaving the key out means what it says."""
    if name in required:
        return "**required**"
    default = value.get("default")
    if default is None or isinstance(default, dict):
        return "-"
    units = next((found for found in map(_units, _all(value)) if found is not None), None)
    if isinstance(default, list):
        return "`[" + ", ".join(f"{entry:g}" for entry in default) + "]`"
    if isinstance(default, float):
        return _value_text(default, units)
    return f"`{json.dumps(default)}`"


def _all(value: Schema) -> Iterator[Schema]:
    yield value
    for item in value.get("anyOf", []):
        yield from _all(item)
