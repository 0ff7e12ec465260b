"""Scenarios: what is read is what was written, mass properties against closed forms, the layout against sampling."""

from __future__ import annotations

import copy
import dataclasses
import datetime
import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scenario_schema, scene_from_table
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scenario.examples import EXAMPLES, example_path
from nospill.scenario.layout import overhang, overlap
from nospill.scene.cargo import Cargo
from nospill.scene.containers import CONTAINERS
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waiting import run_python

VALID: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "bad_scenarios" / "_valid.toml").read_text(encoding="utf-8")
)
LIQUID_MASS = 998.2 * math.pi * 0.035**2 * 0.049


def same(first: Any, second: Any) -> bool:
    """Deep equality of records that hold arrays."""
    if isinstance(first, np.ndarray):
        return isinstance(second, np.ndarray) and np.array_equal(first, second)
    if dataclasses.is_dataclass(first) and not isinstance(first, type):
        names = [field.name for field in dataclasses.fields(first)]
        return type(first) is type(second) and all(same(getattr(first, n), getattr(second, n)) for n in names)
    if isinstance(first, tuple | list):
        return len(first) == len(second) and all(same(a, b) for a, b in zip(first, second, strict=True))
    return bool(first == second)


def scene_with(**tables: Any) -> Scene:
    return scene_from_table({**copy.deepcopy(VALID), **tables}, name="test")


def one(entry: dict[str, Any], fidelity: str = "full") -> Cargo:
    return scene_with(cargo=[{"name": "c", "at": [0, 0], **entry}], fidelity=fidelity).cargo[0]


CUP = {"shape": "cylinder", "radius": 0.035, "height": 0.0991, "liquid": "water", "liquid_height": 0.049}


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_read_and_written_back(name: str, tmp_path: Path) -> None:
    scene = read_scenario(name)
    assert scene.name == name
    scene.save(tmp_path / "scenario.toml")
    again = read_scenario(tmp_path / "scenario.toml")
    assert same(scene, again)
    assert again.text() == (tmp_path / "scenario.toml").read_text(encoding="utf-8")


def test_example_table_and_folder_agree() -> None:
    folder = example_path("matrix-liquid").parent
    assert sorted(file.stem for file in folder.glob("*.toml")) == sorted(EXAMPLES)
    with pytest.raises(ScenarioError, match='did you mean "mixed-tray"'):
        example_path("mixed-trai")


def test_published_data_of_the_liquid_experiment() -> None:
    scene = read_scenario("matrix-liquid")
    assert scene.fidelity == "deliverable" and not scene.motion.tilt_free and scene.motion.end == "published"
    assert scene.planning.path_jerk_weight == 6.4e-3 and scene.motion.path_jerk_limit == 1000
    assert scene.motion.residual_fraction == 0.2 and scene.output_rate == 500 and scene.gravity == STANDARD_GRAVITY
    assert scene.robot.name == "comau-smart-six"
    assert scene.path.length == pytest.approx(1.8379, abs=5e-5)
    assert np.array_equal(scene.tray.size, [0.335, 0.25]) and np.array_equal(scene.tray.tool.position, [0, 0, 0.108])
    centres = [item.position.tolist() for item in scene.cargo]
    assert centres == [[-0.09216, -0.06878], [0.09216, 0.06878], [-0.09216, 0.06878], [0.09216, -0.06878]]
    assert [item.name for item in scene.cargo] == ["c1", "c2", "c3", "c4"]
    for item in scene.cargo:
        assert item.planned_friction == pytest.approx(0.419677, abs=5e-7)
        assert item.planned_friction == pytest.approx(0.9 * math.tan(math.radians(25)), abs=5e-7)
        assert item.filling is not None
        assert item.filling.max_slosh_height == 0.015 and item.filling.liquid_height == 0.049
        assert item.filling.modes.oscillators[0].frequency == pytest.approx(22.582, abs=1e-3)
        assert item.total.mass == pytest.approx(0.197, rel=1e-12)
        assert item.total.centre == pytest.approx([0, 0, 0.0281], abs=1e-15)
        # The published model takes the full cup as a homogeneous cylinder: m R^2/2 about its axis.
        assert item.total.inertia[2, 2] == pytest.approx(0.197 * 0.035**2 / 2, rel=1e-12)
        assert item.empty.mass == pytest.approx(0.00876, abs=1e-5)
        assert item.empty.centre[2] == pytest.approx(0.1054, abs=1e-4)


def test_published_data_of_the_rigid_experiment() -> None:
    scene = read_scenario("matrix-rigid")
    assert scene.motion.tilt_free and scene.fidelity == "deliverable"
    assert scene.planning.path_jerk_weight == scene.planning.tilt_jerk_weight == 1e-5
    for item in scene.cargo:
        assert item.filling is None and item.empty is item.total
        assert item.total.mass == 0.347 and item.total.centre[2] == pytest.approx(0.04955)
        assert item.total.inertia[2, 2] == pytest.approx(0.347 * 0.035**2 / 2)


def test_variants_differ_only_where_they_say() -> None:
    base = read_scenario("matrix-liquid")
    for name, end, weight in (("matrix-liquid-soft-end", "residual", 1e-5), ("matrix-liquid-still", "still", 6.4e-3)):
        other = read_scenario(name)
        assert (other.motion.end, other.planning.path_jerk_weight) == (end, weight)
        assert same(other.cargo, base.cargo) and same(other.path, base.path) and same(other.tray, base.tray)
        assert dataclasses.replace(other.motion, end=base.motion.end) == base.motion
    tilting = read_scenario("matrix-liquid-tilt")
    assert tilting.fidelity == "full" and tilting.motion.tilt_free


def test_defaults() -> None:
    scene = scene_with()
    assert scene.fidelity == "full" and scene.slosh_modes == 20 and scene.output_rate == 500
    assert scene.motion.max_tilt == math.radians(30) and scene.motion.end == "residual" and not scene.motion.tilt_free
    assert scene.planning.intervals == 100 and scene.planning.starts == 1 and scene.planning.linear_solver == "auto"
    assert np.array_equal(scene.tray.tool.position, [0, 0, 0])
    assert scene.cargo[0].friction_reserve == 0.1 and scene.cargo[0].friction == 0.4
    assert scene.cargo[0].footprint_reserve == 0.05
    filling = one(CUP | {"height": 0.06}).filling
    assert filling is not None and filling.max_slosh_height == pytest.approx(0.9 * 0.011)  # a tenth below the rim


def test_numbers_are_read_only() -> None:
    scene = scene_with()
    for array in (scene.tray.size, scene.tray.tool.position, scene.cargo[0].position, scene.cargo[0].total.centre):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_own_friction_offset_and_seed() -> None:
    tray = {**VALID["tray"], "offset": ["1 mm", 0, "108 mm"], "yaw_on_flange": "90 deg", "friction_reserve": "20 %"}
    entry = {"name": "c", "at": [0, 0], **CUP, "friction": 0.2, "friction_reserve": 0, "yaw": "45 deg"}
    scene = scene_with(tray=tray, cargo=[entry])
    assert scene.tray.tool.position == pytest.approx([0.001, 0, 0.108]) and scene.tray.tool.yaw == math.pi / 2
    assert scene.cargo[0].planned_friction == 0.2 and scene.cargo[0].yaw == math.pi / 4


def test_footprint_reserve_of_the_tray_and_of_an_object() -> None:
    entries = [{"name": name, "at": [x, 0], **CUP} for name, x in (("c1", -0.05), ("c2", 0.05))]
    entries[1]["footprint_reserve"] = 0
    scene = scene_with(tray={**VALID["tray"], "footprint_reserve": "20 %"}, cargo=entries)
    assert [item.footprint_reserve for item in scene.cargo] == [0.2, 0.0]


def test_masses_of_a_filled_cup() -> None:
    bare = one(CUP)
    assert bare.total.mass == pytest.approx(LIQUID_MASS, rel=1e-12) and bare.empty.mass == 0
    assert bare.total.centre[2] == pytest.approx(0.0245)
    heavy = one({**CUP, "empty_mass": "30 g"})
    assert heavy.total.mass == pytest.approx(LIQUID_MASS + 0.03) and heavy.empty.mass == 0.03
    assert same(one({**CUP, "mass": LIQUID_MASS + 0.03}).total.mass, pytest.approx(heavy.total.mass))
    assert one({**CUP, "mass": LIQUID_MASS}).empty.mass == 0


@given(
    st.sampled_from([CUP, {**CUP, "shape": "box", "length": 0.07, "width": 0.05}]),
    st.floats(min_value=0.005, max_value=0.5),
    st.floats(min_value=0.03, max_value=0.05),
)
@settings(max_examples=30, deadline=None)
def test_whole_is_cup_and_frozen_liquid(entry: dict[str, Any], empty_mass: float, height: float) -> None:
    """First and second moments about the bottom add up, whatever the split (parallel-axis theorem from the outside)."""
    keys = {key: value for key, value in entry.items() if not (entry["shape"] == "box" and key == "radius")}
    liquid_mass = one(keys).total.mass
    whole = liquid_mass + empty_mass
    implied = (whole * height - liquid_mass * 0.0245) / empty_mass
    if abs(implied - 0.0991 / 2) > 1.49 * 0.0991:
        return
    item = one({**keys, "mass": whole, "centre_of_mass_height": height})
    assert item.total.centre == pytest.approx([0, 0, height], abs=1e-12)
    assert item.empty.mass == pytest.approx(empty_mass) and item.empty.centre[2] == pytest.approx(implied)

    def about_bottom(body: Any) -> np.ndarray:
        c = body.centre
        return body.inertia + body.mass * (c @ c * np.eye(3) - np.outer(c, c))

    frozen = CONTAINERS[entry["shape"]](
        **{key: keys[key] for key in ("radius", "length", "width") if key in keys}, height=0.049
    ).solid_properties(liquid_mass)
    assert about_bottom(item.total) == pytest.approx(about_bottom(item.empty) + about_bottom(frozen), abs=1e-15)


def test_solids_with_a_displaced_centre() -> None:
    solid = {"shape": "box", "length": 0.08, "width": 0.06, "height": 0.1, "mass": 0.3}
    item = one({**solid, "centre_of_mass": ["20 mm", "-10 mm", "30 mm"]})
    assert item.total.centre == pytest.approx([0.02, -0.01, 0.03])
    assert item.total.inertia[0, 0] == pytest.approx(0.3 * (0.06**2 + 0.1**2) / 12)
    assert one({**solid, "centre_of_mass_height": 0.02}).total.centre == pytest.approx([0, 0, 0.02])
    assert one(solid).total.centre == pytest.approx([0, 0, 0.05])


def test_liquid_by_its_properties() -> None:
    oil = one({**CUP, "liquid": {"density": "0.85 g/cm^3", "kinematic_viscosity": "30 cSt"}, "damping": "2 %"})
    assert oil.filling is not None
    assert (oil.filling.liquid.density, oil.filling.liquid.kinematic_viscosity) == (850.0, 30e-6)
    assert oil.filling.modes.oscillators[0].damping == pytest.approx(0.02)
    assert oil.total.mass == pytest.approx(LIQUID_MASS * 850 / 998.2)


def test_path_types() -> None:
    start, through, end = [0.6, 0.4, 1.2], [0.8, 0.0, 1.2], [0.6, -0.4, 1.2]
    yaw = ["0 deg", "90 deg"]
    paths = {
        "line": {"type": "line", "start": start, "end": end, "yaw": yaw},
        "arc": {"type": "arc", "start": start, "through": through, "end": end, "yaw": yaw},
        "waypoints": {"type": "waypoints", "points": [start, through, end], "yaw": yaw},
        "bspline": {"type": "bspline", "control_points": [start, through, through, end], "degree": 3, "yaw": yaw},
    }
    for table in paths.values():
        coefficients = scene_with(path=table).path.coefficients
        assert coefficients[-1, 0] == pytest.approx([*start, 0.0], abs=1e-9)
    assert scene_with(path=paths["line"]).path.length == pytest.approx(0.8)
    assert scene_with(path=paths["arc"]).path.length == pytest.approx(2 * math.atan2(0.4, 0.3) * 0.5, rel=1e-6)
    shifted = scene_with(path={"type": "preset", "name": "arc", "offset": [0, 0, "-10 cm"]}).path
    original = scene_with(path={"type": "preset", "name": "arc"}).path
    assert shifted.coefficients[-1, 0] - original.coefficients[-1, 0] == pytest.approx([0, 0, -0.1, 0])


def test_waypoint_file_goes_into_the_copy(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "way.csv").write_text(
        "x_m,y_m,z_m\n0.6,0.4,1.2\n0.7,0.1,1.2\n0.6,-0.4,1.2\n", encoding="utf-8"
    )
    table = {**VALID, "path": {"type": "waypoints", "file": "way.csv", "yaw": [0, "20 deg"]}}
    scene = scene_from_table(table, name="with spaces & more", folder=tmp_path / "here")
    assert table["path"]["file"] == "way.csv"  # what came in is left alone
    assert scene.name == "with-spaces-more"
    scene.save(tmp_path / "scenario.toml")
    saved = tomllib.loads((tmp_path / "scenario.toml").read_text(encoding="utf-8"))["path"]
    assert "file" not in saved
    assert saved["origin"] == "way.csv, 3 points"
    assert same(read_scenario(tmp_path / "scenario.toml"), scene)


def test_name_comes_from_the_key_or_the_file(tmp_path: Path) -> None:
    text = (Path(__file__).parent / "bad_scenarios" / "_valid.toml").read_text(encoding="utf-8")
    (tmp_path / "lunch.toml").write_text("\ufeff" + text.replace("\n", "\r\n"), encoding="utf-8", newline="")
    assert read_scenario(tmp_path / "lunch.toml").name == "lunch"
    (tmp_path / "lunch.toml").write_text('name = "dinner"\n' + text, encoding="utf-8")
    assert read_scenario(str(tmp_path / "lunch.toml")).name == "dinner"


def disc(at: tuple[float, float], radius: float) -> Cargo:
    return _placed({"shape": "cylinder", "radius": radius}, at, 0.0)


def box(at: tuple[float, float], length: float, width: float, yaw: float) -> Cargo:
    return _placed({"shape": "box", "length": length, "width": width}, at, yaw)


def _placed(keys: dict[str, Any], at: tuple[float, float], yaw: float) -> Cargo:
    tray = {"size": ["9 m", "9 m"], "friction": 0.4}
    entry = {"name": "c", "at": list(at), "yaw": yaw, "height": 0.1, "mass": 1, **keys}
    return scene_with(tray=tray, cargo=[entry]).cargo[0]


def test_overlap_of_known_pairs() -> None:
    assert overlap(disc((0, 0), 0.03), disc((0.05, 0), 0.04)) == pytest.approx(0.02)
    assert overlap(disc((0, 0), 0.03), disc((0.03, 0.04), 0.01)) == pytest.approx(-0.01)
    assert overlap(box((0, 0), 0.1, 0.1, 0), box((0.09, 0.05), 0.1, 0.1, 0)) == pytest.approx(0.01)
    # A square on its corner: half diagonal 0.0707.
    assert overlap(box((0, 0), 0.1, 0.1, math.pi / 4), box((0.12, 0), 0.1, 0.1, 0)) == pytest.approx(
        0.0007107, abs=1e-7
    )
    assert overlap(box((0, 0), 0.1, 0.06, 0), disc((0.08, 0.07), 0.04)) == pytest.approx(0.04 - 0.05)
    assert overlap(disc((0.0, 0.04), 0.02), box((0, 0), 0.1, 0.06, 0)) == pytest.approx(0.01)
    assert overlap(disc((0.0, 0.0), 0.02), box((0, 0), 0.1, 0.06, 0)) == pytest.approx(0.05)
    assert overlap(box((0, 0), 0.06, 0.1, math.pi / 2), disc((0.0, 0.04), 0.02)) == pytest.approx(0.01)


numbers = st.floats(min_value=-0.15, max_value=0.15)
sizes = st.floats(min_value=0.02, max_value=0.12)


@given(numbers, numbers, sizes, sizes, st.floats(min_value=-4, max_value=4), st.booleans())
def test_overlap_against_sampling(x: float, y: float, a: float, b: float, yaw: float, round_one: bool) -> None:
    """Samples of one object that lie in the other exist only where they overlap, and surely where they do by much."""
    first = box((0, 0), 0.1, 0.05, 0.3)
    second = disc((x, y), a / 2) if round_one else box((x, y), a, b, yaw)
    depth = overlap(first, second)
    assert depth == pytest.approx(overlap(second, first), abs=1e-12)
    u, v = np.meshgrid(np.linspace(-0.05, 0.05, 101), np.linspace(-0.025, 0.025, 51))
    points = np.column_stack((u.ravel(), v.ravel())) @ np.array(
        [[math.cos(0.3), math.sin(0.3)], [-math.sin(0.3), math.cos(0.3)]]
    )
    local = (points - [x, y]) @ np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    if round_one:
        inside = np.linalg.norm(points - [x, y], axis=1) < a / 2
    else:
        inside = (np.abs(local[:, 0]) < a / 2) & (np.abs(local[:, 1]) < b / 2)
    if inside.any():
        assert depth > -1e-12
    if depth > 0.002:  # the samples are 1 mm apart
        assert inside.any()


def test_overhang_and_touching() -> None:
    scene = scene_with(cargo=[{"name": "c", "at": ["132.5 mm", 0], **CUP}])
    assert overhang(scene.cargo[0], scene.tray) == pytest.approx(0.0, abs=1e-12)
    flush = [{"name": "a", "at": [0, 0], **CUP}, {"name": "b", "at": ["70 mm", 0], **CUP}]
    assert len(scene_with(cargo=flush).cargo) == 2
    turned = box((0, 0), 0.2, 0.2, math.pi / 4)
    assert overhang(turned, scene.tray) == pytest.approx(0.1 * math.sqrt(2) - 0.125)


def test_every_shape_has_its_keys() -> None:
    assert set(CARGO_TABLES) == set(CONTAINERS)
    for shape, container in CONTAINERS.items():
        assert {field.name for field in dataclasses.fields(container) if field.init} <= set(
            CARGO_TABLES[shape].model_fields
        )


def test_schema_is_strict_and_plain() -> None:
    schema = scenario_schema()
    assert json.loads(json.dumps(schema)) == schema
    tables = [schema, *schema["$defs"].values()]
    assert len(tables) >= 10
    for table in tables:
        assert table["additionalProperties"] is False
        assert all("description" in key or "const" in key for key in table["properties"].values())
    assert schema["required"] == ["robot", "tray"]
    assert schema["anyOf"] == [{"required": ["path"]}, {"required": ["leg"]}]  # one motion, or a cycle
    assert set(schema["$defs"]["CylinderTable"]["required"]) == {"name", "at", "shape", "radius", "height"}


SOMETHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from([0, -1, 1e-320, 1e-150, 1e-12, 1e-4, 1e4, 1e154, -1.7e308])
    | st.text(max_size=8)
    | st.sampled_from(["35 mm", "1 kg", "deg", "water", "cylinder", "arc", 10**400, datetime.date(2025, 7, 28)]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=6,
)


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [at, *(place for key, entry in below for place in places(entry, (*at, key)))]


FULL_TABLES = [VALID, *(tomllib.loads(example_path(name).read_text(encoding="utf-8")) for name in EXAMPLES)]


@given(st.data())
def test_any_value_anywhere_is_read_or_refused_in_one_line(data: st.DataObject) -> None:
    table = copy.deepcopy(data.draw(st.sampled_from(FULL_TABLES)))
    place = data.draw(st.sampled_from([place for place in places(table) if place]))
    holder = table
    for key in place[:-1]:
        holder = holder[key]
    holder[place[-1]] = data.draw(SOMETHING)
    if data.draw(st.booleans()) and isinstance(holder, dict):
        holder[data.draw(st.text(max_size=6))] = data.draw(SOMETHING)
    try:
        scene = scene_from_table(table, name="fuzz")
    except ScenarioError as error:
        assert str(error).startswith("fuzz: ") and len(str(error).splitlines()) == 1 and len(str(error)) < 600
    else:
        assert same(scene, scene_from_table(tomllib.loads(scene.text()), name="other"))


def test_reading_is_light() -> None:
    code = (
        "import sys, nospill.scenario as s; s.read_scenario('matrix-liquid'); s.scenario_schema();"
        "print([m for m in ('casadi', 'scipy', 'matplotlib', 'adam', 'eaik') if m in sys.modules]);"
        "import nospill; nospill.load('coffee-to-go'); print('coal' in sys.modules)"
    )
    done = run_python("-c", code, check=True)
    assert done.stdout.split() == ["[]", "False"]
