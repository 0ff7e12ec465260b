"""Choices that change more than one value: another path, shape or liquid brings the keys that belong to it.

Each returns the values to put by their place (None removes a key), for `Draft.change`.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from nospill.core.paths import Path
from nospill.core.units import quantity
from nospill.errors import ScenarioError
from nospill.scene.containers import CONTAINERS
from nospill.studio.draft import Draft, Key, millimetres
from nospill.studio.fields import NO_LIQUID, OWN_LIQUID, OWN_ROBOT, Field

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
_ABOUT_LIQUID = ("liquid", "liquid_height", "max_slosh_height", "freeboard_reserve", "damping", "empty_mass")
_ABOUT_PATH = ("name", "offset", "start", "through", "end", "points", "file", "control_points", "degree", "knots")
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
    own: dict[str, dict[str, Any]] = {
        "preset": {"name": "arc"},
        "line": {"start": start, "end": end},
        "arc": {"start": start, "through": middle, "end": end},
        "waypoints": {"points": [start, quarter, middle, last_quarter, end]},
    }
    return values | {("path", "type"): kind} | {("path", key): value for key, value in own[kind].items()}


def _points(path: Path | None) -> list[list[float]]:
    """Five points of a path, m, to a millimetre."""
    if path is None:
        return [[0.9, y, 1.2] for y in (-0.4, -0.2, 0.0, 0.2, 0.4)]
    return [[round(float(x), 3) + 0.0 for x in path.at(s)[0, :3]] for s in (0.0, 0.25, 0.5, 0.75, 1.0)]


def _shape(draft: Draft, key: Key, shape: str) -> dict[Key, Any]:
    """As wide as before, as far as its sides can be read."""
    own = key[:-1]
    entry = draft.value(own)
    if shape == entry.get("shape"):
        return {}
    width = _length(entry.get("length"), 2 * _length(entry.get("radius"), _SOME_LENGTH / 2))
    values: dict[Key, Any] = {(*own, side): None for side in ("yaw", *_sides(entry.get("shape"))) if side != "height"}
    for side in _sides(shape):
        if side != "height":
            values[(*own, side)] = millimetres(width / 2 if side == "radius" else width)
    return values | {key: shape}


def _sides(shape: object) -> list[str]:
    """The keys of a shape's sizes."""
    known = CONTAINERS.get(str(shape))
    return [side.name for side in dataclasses.fields(known) if side.init] if known else []


def _liquid(draft: Draft, key: Key, liquid: str) -> dict[Key, Any]:
    own = key[:-1]
    entry = draft.value(own)
    if liquid == OWN_LIQUID:
        return {}
    if liquid == NO_LIQUID:
        values: dict[Key, Any] = {(*own, gone): None for gone in _ABOUT_LIQUID}
        return values | ({(*own, "mass"): _SOME_MASS} if entry.get("mass") is None else {})
    values = {key: liquid}
    if entry.get("liquid_height") is None:
        half = millimetres(_length(entry.get("height"), 2 * _SOME_LENGTH) / 2)
        values |= {(*own, "liquid_height"): half, (*own, "centre_of_mass"): None, (*own, "centre_of_mass_height"): None}
        values |= {(*own, "mass"): None, (*own, "empty_mass"): "30 g"}
    return values


def _length(value: object, otherwise: float) -> float:
    try:
        return quantity(value, "length")
    except ScenarioError:
        return otherwise
