"""The fields of the studio: which value of the table each one edits, and how text becomes a value and back."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from nospill.paths.path import PRESETS
from nospill.robots.description.catalog import ROBOTS
from nospill.scenario.scenes import scenario_schema
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS
from nospill.studio.checks import Fault
from nospill.studio.defaults import all_keys, default_of
from nospill.studio.draft import Draft, Key
from nospill.studio.placing import size_keys

Kind = Literal["quantity", "whole", "list", "one or list", "points", "text", "choice"]
"""How a text is read: a list is several quantities with commas between them, points are one list a line."""

OWN_ROBOT, NO_LIQUID, OWN_LIQUID = "own URDF", "none (solid)", "own liquid"
"""Choices that stand for what the table holds in another form."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_KEY = re.compile(r"\b[a-z]+(?:_[a-z]+)+\b")
_WHOLE = re.compile(r"[+-]?\d{1,18}")


@dataclass(frozen=True, slots=True)
class Field:
    """One field.

    Attributes:
        key: place of its value.
        label: before it; the words of the key, so that messages and labels agree.
        kind: how its text is read.
        choices: of a kind "choice".
        hint: shown when the pointer rests on it; what is allowed and the unit.
        default: shown in it while it is empty.
    """

    key: Key
    label: str
    kind: Kind = "quantity"
    choices: tuple[str, ...] = ()
    hint: str = ""
    default: str = ""


def read_text(text: str, kind: Kind) -> Any:
    """The value for a table from what was typed, right or wrong; None where nothing was, which removes the key."""
    text = text.strip()
    if not text:
        return None
    if kind == "points":
        return [read_text(line, "list") for line in text.splitlines() if line.strip()]
    if kind == "list" or (kind == "one or list" and "," in text):
        return [_scalar(piece) for piece in text.split(",")]
    if kind == "whole":
        return int(text) if _WHOLE.fullmatch(text) else _scalar(text)
    return text if kind in ("text", "choice") else _scalar(text)


def shown_text(value: Any, kind: Kind) -> str:
    """The text of a value of a table, which `read_text` reads as the same."""
    if value is None:
        return ""
    if isinstance(value, list) and kind == "points":
        return "\n".join(shown_text(point, "list") for point in value)
    if isinstance(value, list):
        return ", ".join(shown_text(entry, "quantity") for entry in value)
    return value if isinstance(value, str) else repr(value)


def _scalar(text: str) -> Any:
    text = text.strip()
    if _WHOLE.fullmatch(text):
        return int(text)
    return float(text) if _NUMBER.fullmatch(text) else text


def in_words(text: str) -> str:
    """A message with keys as the labels of fields have them: "liquid height" for `liquid_height`."""
    return _KEY.sub(lambda match: match[0].replace("_", " ") if match[0] in all_keys() else match[0], text)


def field_of(
    key: Key, kind: Kind = "quantity", choices: tuple[str, ...] = (), hint: str = "", sides: str = ""
) -> Field:
    """The field of a key, labelled with the key's own words; `sides` names the entries of a list."""
    words = str(key[-1]).replace("_", " ")
    label = f"{words[:1].upper()}{words[1:]} {sides}".rstrip()
    return Field(key, label, kind, choices, hint, "" if kind == "choice" else default_of(key))


def scenario_fields(draft: Draft) -> dict[str, list[Field]]:
    """The fields of everything but the cargo, under their headings; which ones depends on the draft."""
    return {
        "Robot": _robot(draft),
        "Path": _path(draft),
        "Tray": [
            field_of(("tray", "size"), "list", hint="side lengths, for example 335 mm, 250 mm", sides="x, y"),
            field_of(("tray", "offset"), "one or list", hint="surface beyond the flange: z, or x, y, z; 108 mm"),
            field_of(("tray", "friction"), hint="measured coefficient between tray and cargo"),
            field_of(("tray", "friction_reserve"), hint="part of the friction that is kept back: 0.1 or 10 %"),
            field_of(("tray", "footprint_reserve"), hint="part of the footprints kept back from tipping: 0.05 or 5 %"),
            field_of(("tray", "mass"), hint="of the board without its load; counts for payload and torque"),
        ],
        "Motion": _motion(draft),
        "Planning": [
            field_of(("fidelity",), "choice", ("full", "deliverable"), "whole model, or published equations"),
            field_of(("planning", "intervals"), "whole", hint="20 to 1000; fewer are faster, less smooth"),
            field_of(("planning", "starts"), "whole", hint="starting points of the search that are compared"),
            field_of(("output", "rate"), hint="of the exported samples, for example 500 Hz"),
        ],
    }


def _robot(draft: Draft) -> list[Field]:
    own = draft.value(("robot", "model")) is None
    return [
        field_of(("robot", "model"), "choice", (OWN_ROBOT, *ROBOTS) if own else tuple(ROBOTS)),
        field_of(("robot", "limits_applied"), "choice", ("all", "position and speed")),
        field_of(("robot", "limits", "speed_scale"), hint="factor on all speed limits: 0.8 or 80 %"),
        field_of(("robot", "base_position"), "list", hint="of the arm's root in the world, in m", sides="x, y, z"),
        field_of(("robot", "base_yaw"), hint="turn of the arm's root, for example 90 deg"),
    ]


def _path(draft: Draft) -> list[Field]:
    kind = draft.value(("path", "type"))
    types = ("preset", "line", "arc", "waypoints", "free")
    own: dict[str, list[Field]] = {
        "preset": [
            field_of(("path", "name"), "choice", tuple(PRESETS)),
            field_of(("path", "offset"), "list", hint="moves the whole path: 0, 0, 50 mm", sides="x, y, z"),
        ],
        "line": [_point("start"), _point("end")],
        "arc": [_point("start"), _point("through"), _point("end")],
        "waypoints": [field_of(("path", "points"), "points", hint="one point a line: x, y, z")],
        "bspline": [field_of(("path", "control_points"), "points", hint="one a line: x, y, z")],
        "free": [*_place("start"), *_place("goal")],
    }
    yaw = field_of(("path", "yaw"), "one or list", hint="from start to end: 0 deg, 180 deg; or 0 deg, free, 180 deg")
    return [
        field_of(("path", "type"), "choice", types if kind in types else (*types, str(kind))),
        *own.get(str(kind), []),
        *([] if kind == "free" else [yaw]),
        field_of(("path", "corridor"), "one or list", hint="how far it may leave the path: 50 mm, or some along it"),
    ]


def _place(key: str) -> list[Field]:
    hint = "of the tray's centre, for example 0.9, 0.3, 1.2 or 900 mm, ..."
    return [
        Field(("path", key, "position"), f"{key.capitalize()} x, y, z", "list", hint=hint),
        Field(("path", key, "yaw"), f"{key.capitalize()} yaw", hint="of the tray there: 90 deg"),
    ]


def _point(key: str) -> Field:
    hint = "in the world, for example 0.9, 0.3, 1.2 or 900 mm, ..."
    return field_of(("path", key), "list", hint=hint, sides="x, y, z")


_OF_TILT = ("max_tilt", "tilt_jerk_limit")
"""Keys of `[motion]` that say nothing of a level tray."""
_NOT_SHOWN = ("speed_range", "hold_before", "hold_after")


def _motion(draft: Draft) -> list[Field]:
    """Every key of `[motion]` that holds one value, as the schema describes it."""
    free = draft.value(("motion", "tilt")) == "free"
    return [field for field in _motion_fields() if free or field.key[-1] not in _OF_TILT]


@cache  # the schema takes 60 ms to make
def _motion_fields() -> tuple[Field, ...]:
    found = []
    for name, entry in scenario_schema()["$defs"]["MotionTable"]["properties"].items():
        if name not in _NOT_SHOWN:
            choices = tuple(entry.get("enum", ()))
            found.append(field_of(("motion", name), "choice" if choices else "quantity", choices, entry["description"]))
    return tuple(found)


_SIZE_HINTS = {
    "wall": "thickness of the wall",
    "base_radius": "of what it stands on",
    "base_inner_radius": "of a ring on which it stands",
}


def object_fields(draft: Draft, index: int) -> list[Field]:
    """The fields of one object; which ones depends on its shape and whether it holds a liquid."""
    entry = draft.cargo[index]
    shape = str(entry.get("shape"))
    sides = [key for key in size_keys(shape) if not key.startswith("profile")]
    meridian = [field_of(("cargo", index, "profile"), "points", hint="inside, from the bottom's centre to the rim")]
    filled = entry.get("liquid") is not None
    own = isinstance(entry.get("liquid"), dict)
    liquids = (NO_LIQUID, *([OWN_LIQUID] if own else []), *LIQUIDS)
    inside = [
        ("liquid_height", "height of the liquid at rest above the bottom, 49 mm"),
        ("liquid_volume", "of the liquid instead of its height, 250 ml"),
        ("max_slosh_height", "how far the surface may rise above its rest level"),
        ("empty_mass", "of the container; or give the mass instead"),
    ]

    def at(*parts: str | int) -> Key:
        return ("cargo", index, *parts)

    return [
        field_of(at("name"), "text", hint="letters, digits, - and _"),
        field_of(at("label"), "text", hint="what is read beside the object: beer 0.3 l"),
        field_of(at("shape"), "choice", tuple(CONTAINERS)),
        *([field_of(at("carrier"), "text", hint="the solid in which it stands")] if entry.get("carrier") else []),
        Field(at("at", 0), "At x", hint="of the bottom's centre from the tray's centre, for example 45 mm"),
        Field(at("at", 1), "At y", hint="of the bottom's centre from the tray's centre, for example -70 mm"),
        *([] if shape == "cylinder" else [field_of(at("yaw"), hint="turn about the tray's normal, 30 deg")]),
        *(meridian if shape == "profile" else []),
        *[field_of(at(key), hint=_SIZE_HINTS.get(key, "for example 35 mm")) for key in sides],
        field_of(at("liquid"), "choice", liquids),
        *([field_of(at(key), hint=hint) for key, hint in inside] if filled else []),
        field_of(at("mass"), hint="total, liquid included, for example 0.2 kg"),
        field_of(at("centre_of_mass_height"), hint="above the bottom, liquid included"),
        field_of(at("friction"), hint="of this object"),
    ]


def faults_by_field(fields: Iterable[Field], faults: Sequence[Fault]) -> tuple[dict[Key, list[str]], list[Fault]]:
    """Which fault is shown beside which field: that of its key, or of the key it is a part of, or that is a part of it.

    Returns:
        Sentences by the field's key, and the faults that have no field among these.
    """
    keys = [field.key for field in fields]
    found: dict[Key, list[str]] = {}
    homeless = []
    for fault in faults:
        own = next((key for match in _MATCHES for key in keys if match(key, fault.key)), None)
        if own is None:
            homeless.append(fault)
        else:
            found.setdefault(own, []).append(in_words(fault.text))
    return found, homeless


_MATCHES: tuple[Callable[[Key, Key], bool], ...] = (
    lambda field, fault: field == fault,
    lambda field, fault: len(fault) > 1 and field[: len(fault)] == fault and len(field) > len(fault),
    lambda field, fault: len(field) > 1 and fault[: len(field)] == field,
)
"""From the closest to the loosest: same place, fault of the whole list, fault of one entry."""
