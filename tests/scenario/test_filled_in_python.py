"""Scenarios of classes: what an editor completes is what a file says, and every scene survives its own text."""

from __future__ import annotations

import inspect
import pickle
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import nospill as ns
from nospill.core.trees import flatten
from nospill.core.units import DIMENSIONS
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.scenario.arrays import Counts
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scenario.fields import PLAUSIBLE, JointValues, Measured, Vector, WordOr
from nospill.scenario.obstacle_entries import OBSTACLE_TABLES
from nospill.scenario.path_entries import PATH_TABLES
from nospill.scenario.tables import Table
from nospill.scene import variants
from nospill.scene.sloshing import revolved_modes

ROBOT = ns.Robot(model="ur10e")
TRAY = ns.Tray(size=["335 mm", 0.25], friction=0.47)
HERE, THERE = (0.8, -0.3, 0.9), np.array([0.8, 0.3, 0.9])
WATER: dict[str, Any] = {"at": [0, 0], "liquid": "water", "max_slosh_height": "3 mm", "empty_mass": "50 g"}

CARGO: dict[str, Table] = {
    "cylinder": ns.Cylinder(name="c", radius="35 mm", height=0.1, liquid_height="49 mm", **WATER),
    "box": ns.Box(name="c", length="60 mm", width=0.06, height="80 mm", liquid_height="40 mm", **WATER),
    "tapered": ns.Tapered(
        name="c", bottom_radius="30 mm", top_radius="45 mm", height="0.11 m", liquid_height=0.05, **WATER
    ),
    "bowl": ns.Bowl(name="c", radius="70 mm", bottom_radius="30 mm", height="60 mm", liquid_height="25 mm", **WATER),
    "wine-glass": ns.WineGlass(
        name="c",
        radius="45 mm",
        rim_radius="35 mm",
        bowl_height="0.1 m",
        height=0.2,
        base_radius=0.035,
        liquid_height="0.14 m",
        **WATER,
    ),
    "conical-flask": ns.ConicalFlask(
        name="c",
        bottom_radius=0.045,
        neck_radius=0.0175,
        shoulder_height=0.1,
        height=0.13,
        liquid_height="50 mm",
        **WATER,
    ),
    "round-flask": ns.RoundFlask(
        name="c", radius=0.05, bottom_radius=0.02, neck_radius=0.015, height=0.15, liquid_height="40 mm", **WATER
    ),
    "test-tube": ns.TestTube(name="c", radius="9 mm", height=0.1, base_radius=0.02, liquid_height="60 mm", **WATER),
    "profile": ns.Profile(name="c", profile=[[0, 0], ["30 mm", 0], [0.035, 0.09]], liquid_height="40 mm", **WATER),
}
LEVEL = [0.0, -1.4, 1.6, np.pi / 2 - 0.2, -np.pi / 2, 0.0]
"""rad, of the arm with the tray level."""
PLACES: dict[str, Any] = {"start": ns.Place(position=HERE), "goal": ns.Place(position=THERE, yaw="20 deg")}
PATHS: dict[str, Table] = {
    "preset": ns.PresetPath(name="arc"),
    "bspline": ns.BsplinePath(control_points=[HERE, (0.9, 0, 1), (0.8, 0.1, 1), THERE], degree=3),
    "line": ns.LinePath(start=HERE, end=THERE, yaw=["0 deg", "free", 0.5]),
    "arc": ns.ArcPath(start=HERE, through=["0.9 m", 0.0, 1.0], end=THERE),
    "waypoints": ns.WaypointsPath(points=np.linspace(HERE, THERE, 9), yaw_at_points=np.zeros(9)),
    "joints": ns.JointsPath(points=np.outer([0.0, 0.4], np.eye(6)[0]) + LEVEL, join="stops", joint_tolerance="2 deg"),
    "free": ns.FreePath(
        via=[ns.Via(position=["0.9 m", 0, 1])], region=[ns.Region(at=[1, 0, 1], size=["3 m", "3 m", "3 m"])], **PLACES
    ),
}
FAR: dict[str, Any] = {"name": "o", "at": ["5 m", 0.0, 0.0]}
OBSTACLES: dict[str, Table] = {
    "box": ns.BoxObstacle(size=[0.1, "20 cm", "300 mm"], **FAR),
    "cylinder": ns.CylinderObstacle(radius=0.1, height="1 m", **FAR),
    "sphere": ns.SphereObstacle(radius="5 cm", **FAR),
    "capsule": ns.CapsuleObstacle(radius=0.1, height="1 m", **FAR),
    "halfspace": ns.HalfspaceObstacle(name="o", at=[0, 0, "-2 m"]),
    "mesh": ns.MeshObstacle(points=[[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], **FAR),
}


def scenario(cargo: str, path: str, obstacle: str = "") -> ns.Scenario:
    around: Any = [OBSTACLES[obstacle]] if obstacle else []
    return ns.Scenario(robot=ROBOT, tray=TRAY, cargo=[CARGO[cargo]], path=PATHS[path], obstacle=around)  # type: ignore[arg-type,list-item]


def tables_below(model: type[BaseModel]) -> Iterator[type[Table]]:
    """A table and those that its keys hold."""

    def inside(annotation: Any) -> Iterator[type[Table]]:
        if isinstance(annotation, type) and issubclass(annotation, Table):
            yield from tables_below(annotation)
        for part in get_args(annotation):
            yield from inside(part)

    if issubclass(model, Table):
        yield model
    for field in model.model_fields.values():
        yield from inside(field.annotation)


def test_every_table_of_the_schema_is_a_public_class_of_its_own_name() -> None:
    tables = set(tables_below(ns.Scenario))
    assert len(tables) > 30
    assert {getattr(ns, table.title()) for table in tables} == tables


def test_every_kind_is_here() -> None:
    assert CARGO.keys() == CARGO_TABLES.keys() and PATHS.keys() == PATH_TABLES.keys()
    assert OBSTACLES.keys() == OBSTACLE_TABLES.keys()


def test_only_what_was_set_is_said_as_it_was_written() -> None:
    scene = ns.load(scenario("cylinder", "line"))
    assert scene.source == {
        "name": "scenario",
        "robot": {"model": "ur10e"},
        "tray": {"size": ["335 mm", 0.25], "friction": 0.47},
        "cargo": [
            {"shape": "cylinder", "name": "c", "radius": "35 mm", "height": 0.1, "liquid_height": "49 mm", **WATER}
        ],
        "path": {"type": "line", "start": list(HERE), "end": THERE.tolist(), "yaw": ["0 deg", "free", 0.5]},
    }
    assert scene == ns.load(scene.source) and scene.text().count("\n") < 50


def test_tables_may_stand_in_a_dictionary_and_in_changes() -> None:
    scene = ns.load(scenario("cylinder", "line"))
    mixed = {"robot": {"model": "ur10e"}, "tray": TRAY, "cargo": [CARGO["cylinder"]], "path": PATHS["line"]}
    assert ns.load(mixed) == scene
    changed = scene.changed({"motion": ns.Motion(tilt="free"), "cargo.c": CARGO["box"], "path": PATHS["arc"]})
    assert changed == ns.load(scenario("box", "arc")).changed({"motion.tilt": "free"})
    approach = ns.Approach(start="home", tray="empty", acceleration=5.0)
    stated = scene.changed({"approach": approach}).source["approach"]
    assert stated == {"from": "home", "tray": "empty", "acceleration": 5.0}
    assert pickle.loads(pickle.dumps(scenario("box", "arc"))) == scenario("box", "arc")
    assert repr(ns.Motion(max_tilt="5 deg")) == "Motion(max_tilt='5 deg')"


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (
            lambda: ns.Cylinder(name="c1", at=[0, 0], radiu="35 mm", height=0.1),  # type: ignore[call-arg]
            r'^Cylinder "c1": unknown key "radiu"; did you mean "radius"\?$',
        ),
        (
            lambda: ns.Cylinder(name="c", at=[0, 0], radius="35 kg", height=0.1),
            r'^Cylinder "c": radius "35 kg" is a mass',
        ),
        (lambda: ns.Cylinder(name="c1", at=[0, 0], radius=35, height=0.1), r'radius 35 has no unit.*write "35 mm"$'),
        (lambda: ns.Motion(tilt="fre"), r'^Motion: tilt "fre" is not one of "fixed" or "free"'),  # type: ignore[arg-type]
        (lambda: ns.Scenario(robot=ROBOT), r"^Scenario: tray is missing: the board.*1 more"),  # type: ignore[call-arg]
        (lambda: ns.Robot(limits={"sped": 1}), r'^Robot: limits: unknown key "sped"; did you mean'),  # type: ignore[arg-type]
        (lambda: ns.load(ns.Motion()), r"a Scenario or a dictionary, not a value of type Motion$"),  # type: ignore[arg-type]
        (
            lambda: ns.Scenario(robot=ROBOT, tray=ns.Motion(), cargo=[CARGO["box"]], path=PATHS["arc"]),  # type: ignore[arg-type,list-item]
            r"^Scenario: tray is not a table but Motion\(\).*, in Python Tray\(\.\.\.\)$",
        ),
        (
            lambda: ns.Scenario(robot=ROBOT, tray=TRAY, cargo=CARGO["box"], path=PATHS["arc"]),  # type: ignore[arg-type]
            r"^Scenario: cargo is one Box; write a list, cargo=\[Box\(\.\.\.\)\]$",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line_where_it_is_filled(make: Any, told: str) -> None:
    with pytest.raises(ns.ScenarioError, match=told) as caught:
        make()
    assert "\n" not in str(caught.value)


# --- a scene survives its own text -----------------------------------------------------------------------------------


def drawn_quantity(kind: Measured, draw: st.DrawFn) -> float | str:
    """A value inside the bounds of a key, bare or with a unit."""
    _, plausible, _ = PLAUSIBLE.get(kind.kind or kind.dimension, (0.0, 100.0, ""))
    plausible = 0.06 if kind.dimension == "length" else plausible  # of objects that have room on a tray
    least = next((bound for bound in (kind.at_least, kind.above) if bound is not None), -plausible)
    most = next((bound for bound in (kind.at_most, kind.below) if bound is not None), plausible)
    share = draw(st.floats(0.001, 0.3))
    value = least + share * (min(most, plausible) - least)
    unit = next(iter(DIMENSIONS[kind.dimension].units))
    return f"{value!r} {unit}" if unit and draw(st.booleans()) else value


def drawn_value(field: FieldInfo, draw: st.DrawFn) -> Any:
    """A value for a key, by what the schema says of it; None where only a table or a text of its own would do."""
    for item in field.metadata:
        match item:
            case Measured():
                return drawn_quantity(item, draw)
            case Vector():
                return [drawn_quantity(item.entry, draw) for _ in item.axes]
            case JointValues() | WordOr(several=False):
                return drawn_quantity(item.entry, draw)
            case Counts():
                return [1, draw(st.integers(1, 3))]
    parts = (field.annotation, *get_args(field.annotation))
    literal = next((part for part in parts if get_origin(part) is Literal), None)
    if literal is not None:
        return draw(st.sampled_from(get_args(literal)))
    if bool in parts:
        return draw(st.booleans())
    if int in parts:
        return draw(st.integers(1, 50))
    table = next((part for part in parts if inspect.isclass(part) and issubclass(part, Table)), None)
    return None if table is None else drawn_table(table, draw)


def drawn_table(table: type[Table], draw: st.DrawFn) -> dict[str, Any]:
    """Some keys of a table, all that it needs among them."""
    fields = {field.alias or name: field for name, field in table.model_fields.items()}
    kept = {key for key in fields if fields[key].is_required() or draw(st.booleans())}
    values = {key: drawn_value(fields[key], draw) for key in fields if key in kept}
    return {key: value for key, value in values.items() if value is not None}


@st.composite
def changes(draw: st.DrawFn, scene: ns.Scene) -> dict[str, Any]:
    """Another value for one key of a scene."""
    source = scene.source
    union = {"cargo.0": CARGO_TABLES[source["cargo"][0]["shape"]], "path": PATH_TABLES[source["path"]["type"]]}
    tops = {key: field for key, field in ns.Scenario.model_fields.items() if key not in ("cargo", "path", "obstacle")}
    if "obstacle" in source:
        union["obstacle.0"] = OBSTACLE_TABLES[source["obstacle"][0]["shape"]]
    place = draw(st.sampled_from([*union, *tops]))
    if place in union:
        name, field = draw(st.sampled_from(sorted(union[place].model_fields.items())))
        return {f"{place}.{field.alias or name}": drawn_value(field, draw)}
    value = drawn_value(tops[place], draw)
    if isinstance(value, dict) and place in source:
        return {f"{place}.{key}": entry for key, entry in value.items()}
    return {place: value}


@given(st.data())
@settings(max_examples=12, deadline=None)
def test_what_the_schema_allows_survives_its_own_text(data: st.DataObject) -> None:
    """A scene of any shape and path, with any keys that it takes: text and back is the identity.

    Tolerances are divided by few looks on a coarse mesh: without that those of one object take up to minutes.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(variants, "_LEVELS", 3)
        patch.setattr(variants, "_ANGLES", 3)
        patch.setattr(revolved_modes, "_FEW", 16)
        survives_its_own_text(data)


def survives_its_own_text(data: st.DataObject) -> None:
    obstacle = data.draw(st.sampled_from(["", *OBSTACLES]))
    cargo, path = data.draw(st.sampled_from(list(CARGO))), data.draw(st.sampled_from(list(PATHS)))
    scene = ns.load(scenario(cargo, path, obstacle)).changed({"planning.slosh_modes": 1})
    for _ in range(4):
        try:
            scene = scene.changed(data.draw(changes(scene)))
        except ns.ScenarioError as error:
            assert "\n" not in str(error)
    again = ns.load(tomllib.loads(scene.text()))
    assert again == scene and again.text() == scene.text()
    np.testing.assert_array_equal(flatten(numbers_of(again)), flatten(numbers_of(scene)))
    assert structure_of(again) == structure_of(scene) and again.motion == scene.motion


@pytest.mark.parametrize("cargo", CARGO)
@pytest.mark.parametrize("path", PATHS)
def test_every_shape_on_every_path_survives_its_own_text(cargo: str, path: str, tmp_path: Path) -> None:
    scene = ns.load(scenario(cargo, path, list(OBSTACLES)[list(CARGO).index(cargo) % len(OBSTACLES)]))
    scene.save(tmp_path / "scene.toml")
    assert ns.load(tmp_path / "scene.toml") == scene
