"""The drawn surface against the law of the height, volume and the room inside the container."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.certification.certificate import judge_motion
from nospill.certification.verdict import Trace
from nospill.drawing.geometry import wall_thickness
from nospill.drawing.surfaces import LiquidSurface, liquid_surface
from nospill.drawing.timeline import Film, LiquidTrack, make_film
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.containers import Cylinder
from nospill.scene.surface_tension.tension import ContactLine, liquid_modes
from tests.builders import VESSELS

FILMS = ("tilting_film", "level_film", "mixed_film")


def height_traces(film: Film) -> dict[str, Trace]:
    return {trace.subject: trace for trace in film.judgement.traces if trace.constraint == "slosh height"}


@pytest.mark.parametrize("name", FILMS)
def test_height_at_the_wall_is_the_recorded_one(name: str, request: pytest.FixtureRequest) -> None:
    """At every instant the highest point of the drawn rim is the judge's height, but for the corners of the polygon.

    So it is of the linear surface; that of second order comes below.
    """
    film: Film = request.getfixturevalue(name)
    film = film.at_rate(film.judgement.replay.rate)
    traces = height_traces(film)
    assert set(traces) == set(film.liquids)
    moving = slice(0, len(film.judgement.replay.t))
    for cargo in film.plan.scene.cargo:
        if cargo.filling is None:
            continue
        surface, track, trace = liquid_surface(cargo), film.liquids[cargo.name], traces[cargo.name]
        recorded = trace.value if trace.linear is None else trace.linear
        at_wall = np.isclose(_to_wall(cargo, surface.points), 0.0, atol=1e-9)
        drawn = np.max(np.abs(_linear(surface, track)[moving] @ surface.basis[at_wall].T), axis=1)
        if cargo.shape == "cylinder":
            assert np.all(drawn <= recorded + 1e-9)
            assert np.all(drawn >= np.cos(np.pi / 32) * recorded - 1e-9)
        else:  # the yaw modes are looked at in nine places, and count as if these were in the highest corner
            assert np.all(drawn <= recorded + 0.05 * np.max(recorded))
            assert 0.95 * np.max(recorded) < np.max(drawn) <= np.max(recorded)
        assert np.max(recorded) > 2e-3
        fine = 1e-9 if trace.linear is None else 1e-6  # driven modes are interpolated
        assert np.max(np.abs(track.height[moving] - trace.value)) < fine  # what colours the liquid
        assert track.limit == float(trace.limit[0])


def _linear(surface: LiquidSurface, track: LiquidTrack) -> np.ndarray:
    """Its coordinates without those of second order."""
    return track.coordinates[:, : surface.basis.shape[1]]


def _to_wall(cargo: Cargo, points: np.ndarray) -> np.ndarray:
    """Distance from the true wall, (u,), m."""
    half = np.max(np.abs(cargo.container.outline), axis=0)
    if cargo.shape == "cylinder":
        return half[0] - np.hypot(*points.T)
    return np.min(half - np.abs(points), axis=1)


@pytest.mark.parametrize("name", FILMS)
def test_liquid_stays_inside_its_container(name: str, request: pytest.FixtureRequest) -> None:
    film: Film = request.getfixturevalue(name)
    for cargo in film.plan.scene.cargo:
        if cargo.filling is None:
            continue
        surface = liquid_surface(cargo, film.plan.scene.motion.slosh_height)
        for coordinates in film.liquids[cargo.name].coordinates:
            vertices = surface.vertices(coordinates)
            assert np.all(_to_wall(cargo, vertices[:, :2]) > wall_thickness(cargo.container))
            assert vertices[:, 2].min() >= surface.floor > 0.0
            assert vertices[:, 2].max() < cargo.container.height


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-0.02, 0.02), min_size=82, max_size=82))
def test_no_motion_of_the_liquid_changes_its_volume(mixed_film: Film, values: list[float]) -> None:
    """Modes and lean are antisymmetric, so the rise at a point and at the opposite point cancel; of yaw, mirrored."""
    for cargo in mixed_film.plan.scene.cargo:
        if cargo.filling is None:
            continue
        surface = liquid_surface(cargo)
        rise = surface.rise(np.array(values[: surface.basis.shape[1]]))
        assert cargo.filling.turns == (cargo.shape == "box")
        for index in range(0, len(surface.points), 7):
            signs = [(1, 1), (-1, 1), (1, -1), (-1, -1)] if cargo.filling.turns else [(1, 1), (-1, -1)]
            mirrored = surface.points[index] * np.array(signs)
            places = [np.argmin(np.linalg.norm(surface.points - point, axis=1)) for point in mirrored]
            assert np.allclose(surface.points[places], mirrored, atol=1e-12)
            assert np.sum(rise[places]) == pytest.approx(0.0, abs=1e-12)


def test_steady_lean_is_a_plane(mixed_film: Film) -> None:
    """Under a steady lateral acceleration every carried mode stands at -a/(P g) and the surface is the plane -a x/g."""
    for cargo in mixed_film.plan.scene.cargo:
        if cargo.filling is None:
            continue
        surface = liquid_surface(cargo)
        for axis, lean in ((0, 0.2), (1, -0.1)):
            steady = [
                -lean / mode.stiffness if "xy".index(direction) == axis else 0.0
                for mode in cargo.filling.modes.oscillators
                for direction in mode.directions
            ]
            yaw = surface.basis.shape[1] - len(steady) - 2  # a box's, at rest
            leans = [*np.zeros(max(yaw - 1, 0)), *np.eye(2)[axis] * lean, *np.zeros(min(yaw, 1))]
            found = surface.rise(np.concatenate([steady, leans]))
            assert found == pytest.approx(-lean * surface.points[:, axis], abs=1e-12)


def test_rest_is_flat_and_closed_round_the_side(tilting_film: Film) -> None:
    cargo = tilting_film.plan.scene.cargo[0]
    assert cargo.filling is not None
    surface = liquid_surface(cargo)
    rest = surface.vertices(np.zeros(surface.basis.shape[1]))
    assert np.array_equal(rest, surface.rest.vertices)
    assert np.all(rest[surface.upper, 2] == cargo.filling.liquid_height)
    corners = surface.rest.vertices[surface.rest.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = corners.mean(axis=1) - [0, 0, cargo.filling.liquid_height / 2]
    assert np.all(np.einsum("ij,ij->i", normals, middle) > 0)  # every face looks outwards


def test_a_solid_has_no_surface(mixed_film: Film) -> None:
    with pytest.raises(ValueError, match="no liquid"):
        liquid_surface(mixed_film.plan.scene.cargo[2])


def test_pictures_are_the_judges_instants(tilting_film: Film) -> None:
    played = tilting_film.judgement.replay
    fine = make_film(tilting_film.plan, tilting_film.judgement, rate=played.rate)
    assert np.array_equal(fine.joint_position, played.joint_position)
    assert np.array_equal(fine.liquids["c1"].coordinates[:, :2], played.slosh_displacement[:, :2])
    picked = tilting_film.index(0.5)
    assert tilting_film.t[picked] == pytest.approx(0.5, abs=0.5 / tilting_film.rate)
    assert tilting_film.index(-1.0) == 0
    assert tilting_film.index(99.0) == len(tilting_film.t) - 1


def test_contact_is_the_worst_limit_but_those_of_the_liquid(tilting_film: Film) -> None:
    fine = make_film(tilting_film.plan, tilting_film.judgement, rate=tilting_film.judgement.replay.rate)
    names = ("slip", "tip", "lift", "twist")
    for cargo in tilting_film.plan.scene.cargo:
        uses = [
            trace.use
            for trace in tilting_film.judgement.traces
            if trace.subject == cargo.name and trace.constraint in names
        ]
        assert len(uses) == len(names)
        assert np.array_equal(fine.contact_use[cargo.name], np.maximum(np.max(uses, axis=0), 0.0))


def test_liquids_swing_on_after_the_end_and_the_arm_stands(level_film: Film) -> None:
    played = level_film.judgement.replay
    film = make_film(level_film.plan, level_film.judgement, rate=500.0, length=level_film.length)
    after = film.t > played.t[-1]
    assert np.count_nonzero(after) > 100
    assert np.all(film.joint_position[after] == played.joint_position[-1])
    coordinates = film.liquids["c1"].coordinates
    step = np.linalg.norm(np.diff(coordinates, axis=0), axis=1)
    last = np.flatnonzero(after)[0]
    speed = np.linalg.norm(played.slosh_velocity[-1, :2]) / 500.0
    assert step[last - 1] < 1.3 * speed + 1e-6  # no jump where the motion ends
    assert np.ptp(coordinates[after, 0]) > 1e-4


def test_film_without_liquids(tilting_film: Film) -> None:
    scene = dataclasses.replace(tilting_film.plan.scene, cargo=())
    plan = dataclasses.replace(
        tilting_film.plan, scene=scene, trajectory=dataclasses.replace(tilting_film.plan.trajectory, slosh={})
    )
    from nospill.certification.certificate import judge

    film = make_film(plan, judge(plan.trajectory, scene), rate=20.0)
    assert film.liquids == {} == film.contact_use


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_liquid_of_a_vessel_fills_it_and_follows_its_wall(shape: str) -> None:
    """Edge on the wall at every height of the surface, nothing outside the vessel, nothing above the surface."""
    vessel = VESSELS[shape]
    level = vessel.meridian.bottom + 0.5 * (vessel.height - vessel.meridian.bottom)
    first = read_scenario("pp-two-cups").cargo[0]
    assert first.filling is not None
    modes = vessel.slosh_modes(first.filling.liquid, level, 1)
    filling = dataclasses.replace(
        first.filling, liquid_height=level, modes=modes, floor=float(vessel.inside[0, 1]), max_slosh_height=0.005
    )
    surface = liquid_surface(dataclasses.replace(first, shape=shape, container=vessel, filling=filling))
    wall = wall_thickness(vessel)
    for q in (0.0, 0.002, -0.002):
        vertices = surface.vertices(np.array([q, 0.0, 0.0, 0.0]))
        edge = vertices[surface.edge]
        true = np.array([vessel.meridian.radius(z) for z in edge[:, 2]])
        assert np.all(np.hypot(*edge[:, :2].T) < true)
        assert np.all(np.hypot(*edge[:, :2].T) > true - 2.2 * wall)
        below = vertices[len(surface.upper) :].reshape(-1, surface.around, 3)
        assert np.all(below[..., 2] <= edge[:, 2] + 1e-12)
        assert vertices[:, 2].min() >= surface.floor - 1e-12 > vessel.meridian.bottom - 1e-12
        rise = surface.rise(np.array([q, 0.0, 0.0, 0.0]))[surface.edge]
        assert np.max(rise) == pytest.approx(modes.oscillators[0].surface_gain * abs(q), rel=1e-6)


@pytest.mark.parametrize("line", ["", "free", "pinned"])
def test_leaning_liquid_with_surface_tension_rises_as_the_judge_has_it(line: ContactLine) -> None:
    first = read_scenario("pp-two-cups").cargo[0]
    assert first.filling is not None
    vial = Cylinder(0.008, 0.05)
    modes = liquid_modes(vial, first.filling.liquid, 0.03, 2, contact_line=line)
    filling = dataclasses.replace(first.filling, liquid_height=0.03, modes=modes, max_slosh_height=0.005)
    surface = liquid_surface(dataclasses.replace(first, container=vial, filling=filling))
    assert surface.wall[:, -2:] == pytest.approx(-np.diag(modes.static_correction))
    assert modes.static_correction[0] > 0.0


def test_the_surface_of_second_order_is_drawn_as_it_is_judged(tilting_film: Film) -> None:
    """Crest and colour are the judge's, after the end too; the middle rises as well, and no volume is made."""
    whole = tilting_film.plan
    scene = dataclasses.replace(whole.scene, cargo=whole.scene.cargo[:1])
    judgement = judge_motion(whole.trajectory, scene)
    film = make_film(
        dataclasses.replace(whole, scene=scene), judgement, rate=judgement.replay.rate, length=whole.duration + 0.2
    )
    (cargo,), (trace,) = scene.cargo, height_traces(film).values()
    surface, track = liquid_surface(cargo, "second order"), film.liquids[cargo.name]
    moving = slice(0, len(film.judgement.replay.t))
    assert track.height[moving] == pytest.approx(trace.value, abs=1e-6)
    drawn = np.max((track.coordinates @ surface.basis.T)[:, -surface.around :], axis=1)
    np.testing.assert_allclose(drawn, track.height, atol=0.01 * np.max(track.height))
    linear = surface.crest(track.coordinates)
    assert trace.linear is not None and linear[moving] == pytest.approx(trace.linear, abs=1e-9)
    assert np.max(np.abs(linear - track.height)) > 0.02 * np.max(linear)
    assert np.max(np.abs((track.coordinates @ surface.basis.T)[:, 0])) > 1e-4
