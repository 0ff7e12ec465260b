"""Random scenarios of the campaign: named distributions, and one scenario table for every seed.

A scenario is drawn part by part: robot and way of mounting, tray with its objects, path, limits; then the base is
placed so that the level tray reaches all of the path. A share of the scenarios is left out of reach on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from benchmarks.campaign.paths import PATHS, reachable_base, unreachable_base
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.scenario import scene_from_table
from nospill.scene.liquids import LIQUIDS

STREAM = 20_260
"""First word of every seed sequence: the campaign's own stream of random numbers."""

_ATTEMPTS = 40
_MARGIN = 0.004
_OWN_LIQUID = {"density": 1200.0, "kinematic_viscosity": 1e-5}


@dataclass(frozen=True, slots=True)
class Spread:
    """A number between two bounds, evenly or evenly in its logarithm; `unit` for the table of distributions."""

    low: float
    high: float
    unit: str = ""
    logarithmic: bool = False

    def draw(self, random: np.random.Generator) -> float:
        """One number, rounded to four digits so that the scenario can be read."""
        if self.logarithmic:
            value = math.exp(random.uniform(math.log(self.low), math.log(self.high)))
        else:
            value = random.uniform(self.low, self.high)
        return float(f"{value:.4g}")

    def __str__(self) -> str:
        """For the table."""
        return f"{'log-' if self.logarithmic else ''}uniform, {self.low:g} to {self.high:g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several values by their weights; None: all alike."""

    values: tuple[Any, ...]
    weights: tuple[float, ...] | None = None

    def draw(self, random: np.random.Generator) -> Any:
        """One of them."""
        shares = None if self.weights is None else np.array(self.weights) / sum(self.weights)
        return self.values[int(random.choice(len(self.values), p=shares))]

    def __str__(self) -> str:
        """For the table."""
        if self.weights is None:
            return "any of " + ", ".join(map(str, self.values))
        pairs = zip(self.values, self.weights, strict=True)
        return ", ".join(f"{value} ({weight / sum(self.weights):.0%})" for value, weight in pairs)


@dataclass(frozen=True, slots=True)
class Distributions:
    """What every part of a scenario is drawn from."""

    robot: Choice = Choice(tuple(ROBOTS))
    mounting: Choice = Choice((0.0, 90.0, 180.0), (0.6, 0.15, 0.25))
    unreachable: Choice = Choice((False, True), (0.95, 0.05))
    limits_applied: Choice = Choice(("all", "position and speed"), (0.4, 0.6))
    speed_scale: Choice = Choice((None, 0.8, 0.5, 0.25), (0.7, 0.1, 0.1, 0.1))
    path: Choice = Choice(tuple(PATHS), (0.2, 0.2, 0.25, 0.15, 0.2))
    path_length: Spread = Spread(0.1, 2.0, "m")
    yaw_change: Spread = Spread(-180.0, 180.0, "deg")
    yaw_values: Choice = Choice((2, 3, 4), (0.7, 0.2, 0.1))
    objects: Choice = Choice(tuple(range(1, 9)), (0.26, 0.24, 0.18, 0.12, 0.08, 0.05, 0.04, 0.03))
    kind: Choice = Choice(("cup", "box of liquid", "box", "bottle"), (0.5, 0.15, 0.15, 0.2))
    liquid: Choice = Choice((*LIQUIDS, "own"), (0.5, *[0.1] * (len(LIQUIDS) - 1), 0.1))
    radius: Spread = Spread(0.02, 0.05, "m")
    side: Spread = Spread(0.03, 0.11, "m")
    height: Spread = Spread(0.05, 0.2, "m")
    fill: Spread = Spread(0.3, 0.85, "of the height")
    slosh_share: Spread = Spread(0.1, 1.0, "of the room to the rim", logarithmic=True)
    empty_mass: Spread = Spread(0.02, 0.25, "kg", logarithmic=True)
    solid_mass: Spread = Spread(0.05, 0.8, "kg", logarithmic=True)
    centre_height: Spread = Spread(0.3, 0.6, "of the height")
    tray_side: Spread = Spread(0.2, 0.45, "m")
    tray_mass: Spread = Spread(0.1, 0.8, "kg")
    tray_offset: Spread = Spread(0.02, 0.15, "m")
    friction: Spread = Spread(0.15, 0.8)
    friction_reserve: Spread = Spread(0.0, 0.3)
    footprint_reserve: Choice = Choice((0.05, 0.1, 0.2), (0.6, 0.3, 0.1))
    tilt: Choice = Choice(("fixed", "free"), (0.6, 0.4))
    max_tilt: Spread = Spread(3.0, 40.0, "deg", logarithmic=True)
    end: Choice = Choice(("residual", "published", "still"), (0.8, 0.1, 0.1))
    residual_fraction: Spread = Spread(0.02, 1.0, "of max_slosh_height", logarithmic=True)
    max_duration: Choice = Choice((20.0, 10.0, 40.0), (0.6, 0.2, 0.2))
    slosh_modes: Choice = Choice((1, 2), (0.95, 0.05))
    rate: Choice = Choice((500.0, 125.0, 250.0, 1000.0), (0.7, 0.1, 0.1, 0.1))

    def rows(self) -> list[tuple[str, str]]:
        """Name and distribution of every part, for the report."""
        return [(field.name.replace("_", " "), str(getattr(self, field.name))) for field in fields(self)]


DISTRIBUTIONS = Distributions()
"""Those of the campaign."""


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


def draw_case(seed: int, distributions: Distributions = DISTRIBUTIONS) -> Case:
    """The scenario of a seed: the same wherever the distributions and the catalogue of robots are the same.

    Raises:
        RuntimeError: nothing that the reader accepts came up in many attempts (the distributions are at fault).
    """
    random = np.random.default_rng([STREAM, seed])
    unreachable = distributions.unreachable.draw(random)
    last = ""
    for _ in range(_ATTEMPTS):
        table = _table(random, distributions, seed)
        place = unreachable_base if unreachable else reachable_base
        try:
            found = place(table, random, distributions)
            if found is not None:
                scene = scene_from_table(found, name=f"campaign-{seed}")
                return Case(seed, found, unreachable, _structure(found, scene.path.length))
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
        cargo.append({"name": f"c{len(cargo) + 1}", "at": at.tolist(), **item})
        if len(cargo) == wanted:
            break
    if not cargo:
        raise ScenarioError("no object found room on its tray")
    return cargo


def _object(random: np.random.Generator, known: Distributions) -> tuple[dict[str, Any], float]:
    """An entry without name and place, and the radius of the circle around it, m."""
    kind, height = known.kind.draw(random), known.height.draw(random)
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
    limit = max(1e-3, 0.999 * (height - level) * known.slosh_share.draw(random))
    filling = {
        "liquid": dict(_OWN_LIQUID) if liquid == "own" else liquid,
        "liquid_height": level,
        "max_slosh_height": float(f"{limit:.3g}"),
        "empty_mass": known.empty_mass.draw(random),
    }
    return item | filling, around


def _weight(item: dict[str, Any]) -> float:
    """Mass of an entry, kg."""
    if "mass" in item:
        return item["mass"]
    area = math.pi * item["radius"] ** 2 if item["shape"] == "cylinder" else item["length"] * item["width"]
    liquid = item["liquid"]
    density = liquid["density"] if isinstance(liquid, dict) else LIQUIDS[liquid].density
    return item["empty_mass"] + density * area * item["liquid_height"]
