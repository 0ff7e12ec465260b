"""Variants of an object with a tolerance: the corners that have to be tried.

Limits are monotone in some numbers of an object and convex in others; only their ends need to be tried:

* friction: slip and twist are demand over mu N, nothing else reads it. The low end alone.
* position: forces and moments are linear in it and each limit is a cone about them, exactly so for what is rigid. The
  four corners of the square.
* mass: the same holds for that of a container, two ends. That of a solid cancels in every limit: no variant.
* liquid height: sets the frequency, and with it the phase of what swings on. Both ends and the middle; where the
  frequency changes by more than `FREQUENCY_STEP` between them, as in shallow cups, levels in between as well.
* contact line: free as stated, and pinned.
* contact angle: sets the frequency as the level does. Both ends and the middle, and angles in between likewise.
* frequency: the phase of what swings on. Both ends and the stated one, and `FREQUENCY_STEP` apart in between.
* damping: two ends, and factors in between where these are more than `DAMPING_STEP` apart.
* speed of the motion, where a range is stated: of a liquid every one of `MotionRules.speeds`. Of a solid the wrench is
  linear in the square of the speed, and the limits are cones: both ends.

Frequency, damping and speed are neither convex nor monotone: what holds at their corners held in between wherever it
was tried (docs/uncertainty.md), which is no proof.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from nospill.scene.cargo import Cargo, Filling, Tolerance
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Fidelity, Scene
from nospill.scene.surface_tension.tension import liquid_modes
from nospill.scene.swing import LiquidOffset

FREQUENCY_STEP = 0.01
"""Largest part by which the frequency may differ from one level that is tried to the next: over a motion of 2 s a mode
at 2 Hz gets 0.25 rad out of step, and what neighbours both keep, a level between them exceeds by less than 1 %."""

DAMPING_STEP = 0.0125
"""Largest difference of one damping ratio that is tried to the next, or a quarter of it where that is more: over a
motion of 2 s a mode at 2 Hz then loses a quarter more or less of its swing."""

_WIDE = 4.0 * DAMPING_STEP
_ROUNDING = 1e-9
_FINEST_LEVEL, _FINEST_ANGLE = 1e-5, 1e-3
"""m, rad; levels and angles in between are rounded to these."""
_LEVELS, _ANGLES = 33, 9
"""At which the frequency is looked at on each side."""


VariantId = tuple[str, str]
"""Name of an object and text of its variant."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A perturbed object.

    Attributes:
        name: of the object.
        text: the perturbation in words; empty for the object as stated.
        cargo: the object with its other numbers.
        speed: part of the planned speed at which it is moved.
    """

    name: str
    text: str
    cargo: Cargo
    speed: float = 1.0

    @property
    def id(self) -> VariantId:
        """What names it."""
        return self.name, self.text

    @property
    def cargo_at_speed(self) -> Cargo:
        """The object as it stands in a problem, moved at its speed."""
        return self.cargo if self.speed == 1.0 else replace(self.cargo, speed=self.speed)

    @property
    def label(self) -> str:
        """Name in a scene with several variants, and in messages: "c1 at fill +2 mm"."""
        return f"{self.name} at {self.text}" if self.text else self.name


def variants(cargo: Cargo, *, fidelity: Fidelity, speeds: Sequence[float] = ()) -> tuple[Variant, ...]:
    """Variants of an object: its stated numbers with the least friction, then the corners of its tolerance.

    An object without a tolerance is its own only variant. They are followed by the same at other speeds.
    """
    planned = _variants(cargo, fidelity)
    ends = speeds if cargo.oscillators else sorted({*speeds[:1], *speeds[-1:]}, reverse=True)
    slowed = [_slow_down(item, speed) for speed in ends for item in planned]
    return (*planned, *slowed)


def speed_text(speed: float) -> str:
    """Of a part of the planned speed, in messages."""
    return f"{100.0 * speed:.4g} % of the speed"


def _slow_down(item: Variant, speed: float) -> Variant:
    parts = (item.text, speed_text(speed))
    return replace(item, text=", ".join(part for part in parts if part), speed=speed)


def _variants(cargo: Cargo, fidelity: Fidelity) -> tuple[Variant, ...]:
    tolerance = cargo.tolerance
    if tolerance is None:
        return (Variant(cargo.name, "", cargo),)
    stated = Perturbation(friction=-tolerance.friction)
    perturbations = dict.fromkeys([stated, *_corners(cargo, tolerance)])
    return tuple(Variant(cargo.name, by.text(cargo), perturbed(cargo, by, fidelity=fidelity)) for by in perturbations)


def liquid_offsets(cargo: Cargo) -> tuple[LiquidOffset, ...]:
    """How the liquid of an object differs in its variants, the stated one left out."""
    corners = () if cargo.tolerance is None or cargo.filling is None else _corners(cargo, cargo.tolerance)
    return tuple(own for own in dict.fromkeys(by.of_liquid for by in corners) if own != LiquidOffset())


def _corners(cargo: Cargo, tolerance: Tolerance) -> Iterator[Perturbation]:
    levels, between, factors, masses = (0.0,), (), (1.0,), (0.0,)
    angles, between_angles = (0.0,), ()
    shifts, between_shifts = (0.0,), ()
    owner = _with_liquid(cargo)
    if owner is not None and owner.filling is not None:
        rise, mass = tolerance.liquid_height, tolerance.mass * cargo.empty.mass
        levels, between = ((-rise, 0.0, rise), _levels_between(owner, owner.filling, rise)) if rise else (levels, ())
        turn = tolerance.contact_angle
        angles, between_angles = (
            ((-turn, 0.0, turn), _angles_between(owner, owner.filling, turn)) if turn else (angles, ())
        )
        most = tolerance.frequency
        shifts, between_shifts = ((-most, 0.0, most), _shifts_between(most)) if most else (shifts, ())
        factors = _factors(*tolerance.damping, owner.filling.modes.oscillators[0].damping)
        masses = (-mass, mass) if mass else masses
    side = tolerance.position
    places = [(x, y) for x in (-side, side) for y in (-side, side)] if side else [(0.0, 0.0)]
    lines = (False, True) if tolerance.pinned else (False,)
    of_all = product(levels, factors, places, masses, lines, angles, shifts)
    for level, factor, place, mass, pinned, angle, shift in of_all:
        yield Perturbation(-tolerance.friction, level, factor, place, mass, pinned, angle, shift)
    for level, factor, pinned in product(between, factors, lines):
        yield Perturbation(-tolerance.friction, level, factor, pinned=pinned)
    for angle, factor, pinned in product(between_angles, factors, lines):
        yield Perturbation(-tolerance.friction, 0.0, factor, pinned=pinned, contact_angle=angle)
    for shift, factor, pinned in product(between_shifts, factors, lines):
        yield Perturbation(-tolerance.friction, 0.0, factor, pinned=pinned, frequency=shift)


def _with_liquid(cargo: Cargo) -> Cargo | None:
    """The object, or of a carrier the first with liquid that stands in it; None of another solid."""
    candidates = (cargo,) if cargo.contents is None else cargo.contents.content
    return next((item for item in candidates if item.filling is not None), None)


def _factors(low: float, high: float, ratio: float) -> tuple[float, ...]:
    """Damping factors from one end to the other, no farther apart than `DAMPING_STEP` says for a damping ratio.

    Steps are equal in a measure that is linear in the ratio up to four steps and logarithmic beyond.
    """
    first, last = _steps(low * ratio), _steps(high * ratio)
    count = int(np.ceil(last - first - _ROUNDING))
    between = [_ratio(step) / ratio for step in np.linspace(first, last, count + 1)[1:-1].tolist()]
    return tuple(dict.fromkeys((low, *(float(f"{factor:.4g}") for factor in between), high)))


def _steps(ratio: float) -> float:
    return ratio / DAMPING_STEP if ratio < _WIDE else 4.0 + 4.0 * math.log(ratio / _WIDE)


def _ratio(steps: float) -> float:
    return steps * DAMPING_STEP if steps < 4.0 else _WIDE * math.exp(steps / 4.0 - 1.0)


def _levels_between(cargo: Cargo, filling: Filling, rise: float) -> tuple[float, ...]:
    """Changes of the level, m, that divide both halves of the range into equal steps of the slowest frequency."""

    def frequency(by: float) -> float:
        return _slowest(cargo, replace(filling, liquid_height=filling.liquid_height + by))

    return _between(frequency, rise, _LEVELS, _FINEST_LEVEL)


def _angles_between(cargo: Cargo, filling: Filling, turn: float) -> tuple[float, ...]:
    """Changes of the contact angle, rad, likewise, of the line that is stated."""
    angle = filling.contact_angle
    assert angle is not None  # as `tolerance_of` asks for
    return _between(
        lambda by: _slowest(cargo, replace(filling, contact_angle=angle + by)), turn, _ANGLES, _FINEST_ANGLE
    )


def _between(frequency: Callable[[float], float], most: float, count: int, finest: float) -> tuple[float, ...]:
    """Changes of a number that divide both halves of its range into equal steps of a frequency.

    Args:
        frequency: at a change, rad/s.
        most: either side.
        count: of changes on each side at which the frequency is looked at.
        finest: to which they are rounded.
    """
    between: list[float] = []
    for end in (-most, most):
        stated, last = frequency(0.0), frequency(end)
        steps = int(np.ceil(abs(np.log(last / stated)) / FREQUENCY_STEP - _ROUNDING))
        if steps <= 1:
            continue
        changes = np.linspace(0.0, end, count)
        frequencies = [stated, *(frequency(by) for by in changes[1:-1].tolist()), last]
        wanted = np.linspace(stated, last, steps + 1)[1:-1]
        order = np.argsort(frequencies)
        levels = np.interp(wanted, np.array(frequencies)[order], changes[order])
        between += [round(float(level) / finest) * finest for level in levels]
    return tuple(between)


def _shifts_between(most: float) -> tuple[float, ...]:
    """Changes of the frequency between none and the ends of its range, relative, in equal steps."""
    steps = math.ceil(most / FREQUENCY_STEP - _ROUNDING)
    inside = [round(most * step / steps, 6) for step in range(1, steps)]
    return (*(-shift for shift in inside), *inside)


def _slowest(cargo: Cargo, filling: Filling) -> float:
    """Frequency of the slowest mode of a filling, rad/s."""
    line, angle = filling.contact_line, filling.contact_angle
    modes = liquid_modes(
        cargo.container, filling.liquid, filling.liquid_height, 1, damping=0.1, contact_line=line, contact_angle=angle
    )
    return min(mode.frequency for mode in modes.oscillators)


def variants_by_object(scene: Scene) -> tuple[tuple[Variant, ...], ...]:
    """`variants` of every object, in the order of the cargo."""
    speeds = scene.motion.speeds
    return tuple(variants(cargo, fidelity=scene.fidelity, speeds=speeds) for cargo in scene.cargo)


def labels(by_object: Iterable[Sequence[Variant]]) -> dict[VariantId, str]:
    """Name of every variant where several of one object stand in a scene; the stated one has that of the object."""
    return {item.id: item.label if index else item.name for family in by_object for index, item in enumerate(family)}


def scene_of(scene: Scene, by_object: Iterable[Sequence[Variant]], chosen: Collection[VariantId]) -> Scene:
    """A certain scene whose cargo are chosen variants, in the order of the objects; itself where that is its cargo."""
    names = labels(by_object)
    variants = [(names[item.id], item.cargo_at_speed) for family in by_object for item in family if item.id in chosen]
    cargo = tuple(own if own.name == name else replace(own, name=name) for name, own in variants)
    same = len(cargo) == len(scene.cargo) and all(a is b for a, b in zip(cargo, scene.cargo, strict=True))
    return scene if same else replace(scene, cargo=cargo)
