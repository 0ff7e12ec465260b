"""Choices that change more than one value: another path, shape or liquid brings the keys that belong to it.

Each returns the values to put by their place (None removes a key), for `Draft.change`.
"""

from __future__ import annotations

from typing import Any

from nospill.core.units import quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.studio.draft import Draft, Key, millimetres
from nospill.studio.fields import NO_LIQUID, OWN_LIQUID, OWN_ROBOT, Field
from nospill.studio.obstacles import choose_shape
from nospill.studio.placing import size_keys

NEW_CUP: dict[str, Any] = {
    "name": "cup",
    "at": ["0 mm", "0 mm"],
    "shape": "cylinder",
    "radius": "35 mm",
    "height": "100 mm",
    "liquid": "water",
    "liquid_height": "50 mm",
    "max_slosh_height": "15 mm",
    "empty_mass": "30 g",
}
NEW_SOLID: dict[str, Any] = {
    "name": "solid",
    "at": ["0 mm", "0 mm"],
    "shape": "cylinder",
    "radius": "30 mm",
    "height": "80 mm",
    "mass": "0.3 kg",
}
_ABOUT_LIQUID = (
    *("liquid", "liquid_height", "liquid_volume", "max_slosh_height", "freeboard_reserve"),
    *("damping", "empty_mass"),
)
_ABOUT_PATH = (
    *("name", "offset", "start", "through", "end", "points", "file", "control_points", "degree", "knots"),
    *("goal", "way"),
)
_SOME_LENGTH, _SOME_MASS = 0.07, "0.2 kg"


def choose(draft: Draft, field: Field, choice: str, *, path: Path | None) -> dict[Key, Any]:
    """What a choice in a field changes.

    Args:
        draft: before it.
        field: of the kind "choice".
        choice: one of its choices.
        path: of the last scene that was right, whose points a new type of path starts from.
    """
    if field.key == ("robot", "model"):
        return {} if choice == OWN_ROBOT else _robot(choice)
    if field.key == ("path", "type"):
        return _path(choice, path) if choice != draft.value(field.key) else {}
    if field.key[0] == "obstacle" and isinstance(field.key[1], int):
        return choose_shape(draft, field.key[1], choice)
    if field.key[0] == "cargo" and field.key[-1] == "shape":
        return _shape(draft, field.key, choice)
    if field.key[0] == "cargo" and field.key[-1] == "liquid":
        return _liquid(draft, field.key, choice)
    return {field.key: choice}


def _robot(model: str) -> dict[Key, Any]:
    """Another arm; what names the joints or frames of the old one goes with it."""
    old = ("urdf", "urdf_text", "tip", "locked", "home")
    return {("robot", "model"): model, **{("robot", key): None for key in old}}


def _path(kind: str, path: Path | None) -> dict[Key, Any]:
    """Keys of another type of path, through points of the old one."""
    values: dict[Key, Any] = {("path", key): None for key in _ABOUT_PATH}
    start, quarter, middle, last_quarter, end = _points(path)
    by_kind: dict[str, dict[str, Any]] = {
        "preset": {"name": "arc"},
        "line": {"start": start, "end": end},
        "arc": {"start": start, "through": middle, "end": end},
        "waypoints": {"points": [start, quarter, middle, last_quarter, end]},
        "free": {"start": {"position": start}, "goal": {"position": end}, "yaw": None},
    }
    return values | {("path", "type"): kind} | {("path", key): value for key, value in by_kind[kind].items()}


def _points(path: Path | None) -> list[list[float]]:
    """Five points of a path, m, to a millimetre."""
    if path is None:
        return [[0.9, y, 1.2] for y in (-0.4, -0.2, 0.0, 0.2, 0.4)]
    return [[round(float(x), 3) + 0.0 for x in path.at(s)[0, :3]] for s in (0.0, 0.25, 0.5, 0.75, 1.0)]


def _shape(draft: Draft, key: Key, shape: str) -> dict[Key, Any]:
    """As wide as before, as far as its sides can be read."""
    entry_key = key[:-1]
    entry = draft.value(entry_key)
    if shape == entry.get("shape"):
        return {}
    radius = _length(entry.get("bottom_radius"), _SOME_LENGTH / 2)
    width = _length(entry.get("length"), 2 * _length(entry.get("radius"), radius))
    height = _length(entry.get("height"), 2 * _SOME_LENGTH)
    gone = {"yaw", *size_keys(entry.get("shape"))}
    values: dict[Key, Any] = {(*entry_key, side): None for side in gone}
    # Where there is a flat bottom, it is the base.
    flat = bool({"bottom_radius", "profile"} & set(size_keys(shape)))
    for side in size_keys(shape):
        if side == "base_radius" and flat:
            continue
        if side in _PARTS_OF_WIDTH:
            values[(*entry_key, side)] = millimetres(_PARTS_OF_WIDTH[side] * width)
        elif side in _PARTS_OF_HEIGHT:
            values[(*entry_key, side)] = millimetres(_PARTS_OF_HEIGHT[side] * height)
        elif side == "height":
            values[(*entry_key, side)] = entry.get("height", millimetres(height))
        elif side == "profile":
            values[(*entry_key, side)] = [[0.0, 0.0], [width / 2, 0.0], [width / 2, height]]
    return values | {key: shape}


_PARTS_OF_WIDTH = {
    "length": 1.0,
    "width": 1.0,
    "radius": 0.5,
    "top_radius": 0.5,
    "rim_radius": 0.4,
    "bottom_radius": 0.35,
    "base_radius": 0.35,
    "neck_radius": 0.2,
}
_PARTS_OF_HEIGHT = {"bowl_height": 0.5, "shoulder_height": 0.7}


def _liquid(draft: Draft, key: Key, liquid: str) -> dict[Key, Any]:
    entry_key = key[:-1]
    entry = draft.value(entry_key)
    if liquid == OWN_LIQUID:
        return {}
    if liquid == NO_LIQUID:
        values: dict[Key, Any] = {(*entry_key, gone): None for gone in _ABOUT_LIQUID}
        return values | ({(*entry_key, "mass"): _SOME_MASS} if entry.get("mass") is None else {})
    values = {key: liquid}
    if entry.get("liquid_height") is None and entry.get("liquid_volume") is None:
        half = millimetres(_length(entry.get("height"), 2 * _SOME_LENGTH) / 2)
        values |= {
            (*entry_key, "liquid_height"): half,
            (*entry_key, "centre_of_mass"): None,
            (*entry_key, "centre_of_mass_height"): None,
        }
        values |= {(*entry_key, "mass"): None, (*entry_key, "empty_mass"): "30 g"}
    return values


def _length(value: object, otherwise: float) -> float:
    try:
        return quantity(value, "length")
    except ScenarioError:
        return otherwise
