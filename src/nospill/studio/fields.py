"""The fields of the studio: which value of the table each one edits, and how text becomes a value and back."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from nospill.core.paths import PRESETS
from nospill.robots.description.catalog import ROBOTS
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS
from nospill.studio.checks import Fault
from nospill.studio.draft import Draft, Key
from nospill.studio.placing import size_keys

Kind = Literal["quantity", "whole", "list", "one or list", "points", "text", "choice"]
"""How a text is read: a list is several quantities with commas between them, points are one list a line."""

OWN_ROBOT, NO_LIQUID, OWN_LIQUID = "own URDF", "none (solid)", "own liquid"
"""Choices that stand for what the table holds in another form."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_WHOLE = re.compile(r"[+-]?\d{1,18}")


@dataclass(frozen=True, slots=True)
class Field:
    """One field.

    Attributes:
        key: place of its value.
        label: before it.
        kind: how its text is read.
        choices: of a kind "choice".
        hint: shown when the pointer rests on it; what is allowed and the unit.
    """

    key: Key
    label: str
    kind: Kind = "quantity"
    choices: tuple[str, ...] = ()
    hint: str = ""


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


def scenario_fields(draft: Draft) -> dict[str, list[Field]]:
    """The fields of everything but the cargo, under their headings; which ones depends on the draft."""
    return {
        "Robot": _robot(draft),
        "Path": _path(draft),
        "Tray": [
            Field(("tray", "size"), "Size x, y", "list", hint="side lengths, for example 335 mm, 250 mm"),
            Field(("tray", "offset"), "Offset", "one or list", hint="surface beyond the flange: z, or x, y, z; 108 mm"),
            Field(("tray", "friction"), "Friction", hint="measured coefficient between tray and cargo"),
            Field(("tray", "friction_reserve"), "Reserve", hint="part of the friction that is kept back: 0.1 or 10 %"),
            Field(("tray", "footprint_reserve"), "Tip reserve", hint="part of the footprints kept back: 0.05 or 5 %"),
            Field(("tray", "mass"), "Mass", hint="of the board without its load; counts for payload and torque"),
        ],
        "Motion": _motion(draft),
        "Planning": [
            Field(("fidelity",), "Physics", "choice", ("full", "deliverable"), "whole model, or published equations"),
            Field(("planning", "intervals"), "Intervals", "whole", hint="20 to 1000; fewer are faster, less smooth"),
            Field(("planning", "starts"), "Starts", "whole", hint="starting points of the search"),
            Field(("output", "rate"), "Output rate", hint="of the exported samples, for example 500 Hz"),
        ],
    }


def _robot(draft: Draft) -> list[Field]:
    own = draft.value(("robot", "model")) is None
    return [
        Field(("robot", "model"), "Model", "choice", (OWN_ROBOT, *ROBOTS) if own else tuple(ROBOTS)),
        Field(("robot", "limits_applied"), "Limits", "choice", ("all", "position and speed")),
        Field(("robot", "limits", "speed_scale"), "Speed scale", hint="factor on all speed limits: 0.8 or 80 %"),
        Field(("robot", "base_position"), "Base x, y, z", "list", hint="of the arm's root in the world, 0, 0, 0"),
        Field(("robot", "base_yaw"), "Base yaw", hint="turn of the arm's root, for example 90 deg"),
    ]


def _path(draft: Draft) -> list[Field]:
    kind = draft.value(("path", "type"))
    types = ("preset", "line", "arc", "waypoints")
    own: dict[str, list[Field]] = {
        "preset": [
            Field(("path", "name"), "Preset", "choice", tuple(PRESETS)),
            Field(("path", "offset"), "Shift x, y, z", "list", hint="of the whole path, for example 0, 0, 50 mm"),
        ],
        "line": [_point("start", "Start"), _point("end", "End")],
        "arc": [_point("start", "Start"), _point("through", "Through"), _point("end", "End")],
        "waypoints": [Field(("path", "points"), "Points", "points", hint="one point a line: x, y, z")],
        "bspline": [Field(("path", "control_points"), "Control points", "points", hint="one a line: x, y, z")],
    }
    return [
        Field(("path", "type"), "Type", "choice", types if kind in types else (*types, str(kind))),
        *own.get(str(kind), []),
        Field(("path", "yaw"), "Yaw", "list", hint="of the tray from start to end: 0 deg, 180 deg"),
    ]


def _point(key: str, label: str) -> Field:
    return Field(
        ("path", key), f"{label} x, y, z", "list", hint="in the world, for example 0.9, 0.3, 1.2 or 900 mm, ..."
    )


def _motion(draft: Draft) -> list[Field]:
    free = draft.value(("motion", "tilt")) == "free"
    return [
        Field(("motion", "tilt"), "Tilt", "choice", ("fixed", "free"), "whether the tray may pitch and roll"),
        *([Field(("motion", "max_tilt"), "Largest tilt", hint="below 60 deg; 30 deg when empty")] if free else []),
        Field(("motion", "end"), "End", "choice", ("residual", "published", "still"), "what the liquids do at the end"),
        Field(("motion", "residual_fraction"), "Residual", hint="height after the end over the limit; 0.2 when empty"),
        Field(
            ("motion", "path_jerk_limit"),
            "Path jerk",
            hint="bound on s''' in 1/s^3; from max_jerk when empty",
        ),
        *([Field(("motion", "tilt_jerk_limit"), "Tilt jerk", hint="rad/s^3; 1000 when empty")] if free else []),
        Field(("motion", "max_duration"), "Longest", hint="longest motion that is considered; 20 s when empty"),
    ]


_SIZE_HINTS = {
    "wall": "thickness of the wall; none when empty",
    "base_radius": "of what it stands on; the flat bottom when empty",
    "base_inner_radius": "of a ring on which it stands; a disc when empty",
}


def object_fields(draft: Draft, index: int) -> list[Field]:
    """The fields of one object; which ones depends on its shape and whether it holds a liquid."""
    entry = draft.cargo[index]
    shape = str(entry.get("shape"))
    # A profile is drawn elsewhere; it comes from the file.
    sides = [key for key in size_keys(shape) if not key.startswith("profile")]
    filled = entry.get("liquid") is not None
    own = isinstance(entry.get("liquid"), dict)
    liquids = (NO_LIQUID, *([OWN_LIQUID] if own else []), *LIQUIDS)
    inside = [
        ("liquid_height", "Fill", "height of the liquid at rest above the bottom, 49 mm"),
        ("liquid_volume", "Volume", "of the liquid instead of its height, 250 ml"),
        ("max_slosh_height", "Slosh limit", "how far the surface may rise; to the rim when empty"),
        ("empty_mass", "Empty mass", "of the container; or give the mass instead"),
    ]

    def at(*parts: str | int) -> Key:
        return ("cargo", index, *parts)

    return [
        Field(at("name"), "Name", "text", hint="letters, digits, - and _"),
        Field(at("shape"), "Shape", "choice", tuple(CONTAINERS)),
        Field(at("at", 0), "x", hint="of the bottom's centre from the tray's centre, for example 45 mm"),
        Field(at("at", 1), "y", hint="of the bottom's centre from the tray's centre, for example -70 mm"),
        *(
            []
            if shape == "cylinder"
            else [Field(at("yaw"), "Turn", hint="about the tray's normal, for example 30 deg")]
        ),
        *[
            Field(at(key), key.replace("_", " ").capitalize(), hint=_SIZE_HINTS.get(key, "for example 35 mm"))
            for key in sides
        ],
        Field(at("liquid"), "Liquid", "choice", liquids),
        *([Field(at(key), label, hint=hint) for key, label, hint in inside] if filled else []),
        Field(at("mass"), "Mass", hint="total, liquid included, for example 0.2 kg"),
        Field(at("centre_of_mass_height"), "Centre of mass", hint="height above the bottom, liquid included"),
        Field(at("friction"), "Friction", hint="of this object; the tray's when empty"),
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
            found.setdefault(own, []).append(fault.text)
    return found, homeless


_MATCHES: tuple[Callable[[Key, Key], bool], ...] = (
    lambda field, fault: field == fault,
    lambda field, fault: len(fault) > 1 and field[: len(fault)] == fault and len(field) > len(fault),
    lambda field, fault: len(field) > 1 and fault[: len(field)] == field,
)
"""From the closest to the loosest: same place, fault of the whole list, fault of one entry."""
