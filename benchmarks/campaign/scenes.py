"""Random scenarios of the campaign: named distributions, and one scenario table for every seed.

A scenario is drawn part by part: robot and way of mounting, tray with its objects, path, limits; then the base is
placed so that the level tray reaches all of the path. A share of the scenarios is left out of reach on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.campaign.combined import combined_distributions, combined_table, features_of
from benchmarks.campaign.distributions import FIRST_COMBINED, Distributions, distributions_of
from benchmarks.campaign.paths import reachable_base, unreachable_base
from benchmarks.campaign.vessels import RACK_EDGE, draw_rack, draw_vessel
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.scenario import scene_from_table
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scene.liquids import LIQUIDS

STREAM = 20_260
"""First word of every seed sequence: the campaign's own stream of random numbers."""

_ATTEMPTS = 40
_MARGIN = 0.004
_OWN_LIQUID = {"density": 1200.0, "kinematic_viscosity": 1e-5}


@dataclass(frozen=True, slots=True)
class Case:
    """One scenario of the campaign.

    Attributes:
        seed: which. table: content of its scenario file.
        unreachable: whether it was left out of reach on purpose.
        structure: robot, path, objects and rules in a few words.
    """

    seed: int
    table: dict[str, Any]
    unreachable: bool
    structure: str


def draw_case(seed: int) -> Case:
    """The scenario of a seed: the same wherever the distributions and the catalogue of robots are the same.

    Raises:
        RuntimeError: nothing that the reader accepts came up in many attempts (the distributions are at fault).
    """
    random, combined = np.random.default_rng([STREAM, seed]), seed >= FIRST_COMBINED
    distributions = combined_distributions(seed) if combined else distributions_of(seed)
    unreachable = distributions.unreachable.draw(random)
    last = ""
    for _ in range(_ATTEMPTS):
        table = _table(random, distributions, seed)
        place = unreachable_base if unreachable else reachable_base
        try:
            found = place(table, random, distributions)
            if found is not None:
                scene = scene_from_table(found, name=f"campaign-{seed}")
                structure = _structure(found, scene.path.length)
                if combined:
                    # What the reader refuses of a combination is an answer, and no reason to draw again.
                    features = ", ".join(features_of(seed))
                    return Case(seed, combined_table(found, scene, seed), unreachable, f"{structure}; {features}")
                return Case(seed, found, unreachable, structure)
        except ScenarioError as error:  # a draw the reader refuses, for example a liquid too viscous to slosh
            last = str(error)
    raise RuntimeError(f"seed {seed}: no scenario in {_ATTEMPTS} attempts, the last: {last or 'out of reach'}")


def _structure(table: dict[str, Any], length: float) -> str:
    cargo = table["cargo"]
    liquids = sum("liquid" in item for item in cargo)
    tilt = f"tilt to {table['motion']['max_tilt']}" if table["motion"]["tilt"] == "free" else "level"
    return (
        f"{table['robot']['model']}, {table['path']['type']} of {length:.2f} m, {liquids} liquids, "
        f"{len(cargo) - liquids} solids, {tilt}, {table['motion']['end']}"
    )


def _table(random: np.random.Generator, known: Distributions, seed: int) -> dict[str, Any]:
    robot = load_robot(known.robot.draw(random))
    arm: dict[str, Any] = {"model": robot.name, "limits_applied": known.limits_applied.draw(random)}
    scale = known.speed_scale.draw(random)
    if scale is not None:
        arm["limits"] = {"speed_scale": scale}
    size = [known.tray_side.draw(random), known.tray_side.draw(random)]
    tray = {
        "size": size,
        "friction": known.friction.draw(random),
        "friction_reserve": known.friction_reserve.draw(random),
        "footprint_reserve": known.footprint_reserve.draw(random),
        "offset": known.tray_offset.draw(random),
        "mass": known.tray_mass.draw(random),
    }
    cargo = _cargo(random, known, size)
    if robot.payload is not None:
        while len(cargo) > 1 and tray["mass"] + sum(map(_weight, cargo)) > robot.payload:
            cargo.pop()
    return {
        "name": f"campaign-{seed}",
        "fidelity": "full",
        "robot": arm,
        "tray": tray,
        "cargo": cargo,
        "path": {},
        "motion": {
            "tilt": known.tilt.draw(random),
            "max_tilt": f"{known.max_tilt.draw(random)} deg",
            "end": known.end.draw(random),
            "residual_fraction": known.residual_fraction.draw(random),
            "max_duration": known.max_duration.draw(random),
        },
        "planning": {"slosh_modes": known.slosh_modes.draw(random)},
        "output": {"rate": known.rate.draw(random)},
    }


def _cargo(random: np.random.Generator, known: Distributions, size: Sequence[float]) -> list[dict[str, Any]]:
    """Objects that stand apart from each other on the tray; the ones that find no room are left out."""
    cargo: list[dict[str, Any]] = []
    circles: list[tuple[np.ndarray, float]] = []
    wanted = known.objects.draw(random)
    for _ in range(10 * wanted):
        item, around = _object(random, known)
        room = np.array(size) / 2 - around - _MARGIN
        if np.any(room < 0.0):
            continue
        at = np.round(random.uniform(-room, room), 4)
        if any(np.linalg.norm(at - centre) < around + other + _MARGIN for centre, other in circles):
            continue
        circles.append((at, around))
        name, vials = f"c{len(circles)}", item.pop("vials", None)
        cargo.append({"name": name, "at": at.tolist(), **item})
        if vials is not None:
            cargo.append({"name": f"v{len(circles)}", "at": [0.0, 0.0], "carrier": name, **vials})
        if len(circles) == wanted:
            break
    if not cargo:
        raise ScenarioError("no object found room on its tray")
    return cargo


def _object(random: np.random.Generator, known: Distributions) -> tuple[dict[str, Any], float]:
    """An entry without name and place, that of a rack with its vials, and the radius of the circle around it, m."""
    kind, height = known.kind.draw(random), known.height.draw(random)
    if kind in ("vessel", "vials", "rack"):
        item, around, container = draw_vessel(random, array=kind != "vessel")
        level = container.level(item["liquid_volume"]) if "liquid_volume" in item else item["liquid_height"]
        item |= _filling(random, known, container.height - level)
        if kind != "rack":
            return item, around
        rack = draw_rack(random, item, container) | {"mass": known.solid_mass.draw(random)}
        return rack, around + 2 * RACK_EDGE
    if kind in ("cup", "bottle"):
        radius = known.radius.draw(random)
        item: dict[str, Any] = {"shape": "cylinder", "radius": radius, "height": height}
        around = radius
    else:
        length, width = known.side.draw(random), known.side.draw(random)
        yaw = f"{random.uniform(0.0, 180.0):.1f} deg"
        item = {"shape": "box", "length": length, "width": width, "height": height, "yaw": yaw}
        around = math.hypot(length, width) / 2
    if kind in ("box", "bottle"):
        centre = float(f"{height * known.centre_height.draw(random):.4g}")
        return item | {"mass": known.solid_mass.draw(random), "centre_of_mass_height": centre}, around
    liquid, level = known.liquid.draw(random), float(f"{height * known.fill.draw(random):.4g}")
    return item | _filling(random, known, height - level, liquid) | {"liquid_height": level}, around


def _filling(random: np.random.Generator, known: Distributions, room: float, liquid: str = "") -> dict[str, Any]:
    """Liquid, its limit and the vessel's own mass; `room`: to the rim, m."""
    liquid = liquid or known.liquid.draw(random)
    limit = max(1e-3, 0.999 * room * known.slosh_share.draw(random))
    return {
        "liquid": dict(_OWN_LIQUID) if liquid == "own" else liquid,
        "max_slosh_height": float(f"{limit:.3g}"),
        "empty_mass": known.empty_mass.draw(random),
    }


def _weight(item: dict[str, Any]) -> float:
    """Mass of an entry, kg, of all its objects where it is an array."""
    if "mass" in item:
        return item["mass"]
    container = CARGO_TABLES[item["shape"]].model_validate({"name": "weighed", "at": [0.0, 0.0]} | item).container()
    liquid = item["liquid"]
    density = liquid["density"] if isinstance(liquid, dict) else LIQUIDS[liquid].density
    volume = item.get("liquid_volume") or container.volume(item["liquid_height"])
    return (item["empty_mass"] + density * volume) * math.prod(item.get("array", {"count": [1]})["count"])
