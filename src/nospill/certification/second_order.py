"""Slosh heights to the second order in the place of the linear ones, where a scene asks for them.

The judge's own waves are the first order, as they are integrated on its grid with the mass of the first mode on its
paraboloid; what they drive is added to their surface round the wall (`potential_flow.driven`). Forces and everything
else stay those of the modes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from nospill.certification.replay import Replay
from nospill.certification.verdict import Trace
from nospill.core.units import as_written
from nospill.errors import ModelError
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.potential_flow import driven, rows_at, second_order_states
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.heights import to_second_order
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import wall_gains


def with_second_order(traces: Iterable[Trace], scene: Scene, played: Replay) -> tuple[Trace, ...]:
    """The traces, those of slosh heights on the grid of a replay to the second order where the scene asks for it."""
    liquids = {
        cargo.name: (cargo, modes)
        for cargo, modes in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
        if to_second_order(cargo, scene.motion.slosh_height)
    }

    def judged(trace: Trace) -> Trace:
        cargo, modes = liquids[trace.subject]
        q, qd = played.slosh_displacement[:, modes], played.slosh_velocity[:, modes]
        value = crests_of_second_order(cargo, played.body, q, qd, 1.0 / played.rate)
        return replace(trace, value=value, margin=trace.limit - value, linear=trace.value)

    return tuple(
        judged(trace) if trace.constraint == SloshHeight.name and trace.subject in liquids else trace
        for trace in traces
    )


def crests_of_second_order(
    cargo: Cargo, body: np.ndarray, displacement: np.ndarray, velocity: np.ndarray, step: float
) -> np.ndarray:
    """Greatest heights (m,) round the wall of a cylinder, or in the corners of a box, above the rest level, m.

    Arguments as of `second_order_surface`.
    """
    return second_order_surface(cargo, body, displacement, velocity, step)[0]


def second_order_surface(
    cargo: Cargo, body: np.ndarray, displacement: np.ndarray, velocity: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """These heights, and what the second order adds in each of its modes (m, J), m.

    Args:
        cargo: whose liquid, at full fidelity.
        body: (9, m) of the tray, as `Replay.body`.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k) likewise, m/s.
        step: between the instants, s.
    """
    filling = cargo.filling
    assert filling is not None  # `to_second_order` says so
    own, liquid = _own_rows(cargo, body), driven(cargo)
    added = driven_states(cargo, body, displacement, velocity, step)[:, 0]
    linear, yaw = _linear_heights(filling, own, displacement)
    modes = liquid.terms.basin.modes
    half = np.max(np.abs(modes.wall), axis=0)
    if isinstance(cargo.container, Cylinder):
        where = slice(None)
    else:
        where = np.flatnonzero(
            np.all(np.abs(modes.wall) > (1 - 1e-9) * half, axis=1)
        )  # no yaw mode is higher elsewhere
    surface = linear @ (modes.wall[where] / half).T + added @ modes.wall_shape[where].T
    return np.max(surface, axis=1) + yaw, added


def driven_states(
    cargo: Cargo, body: np.ndarray, displacement: np.ndarray, velocity: np.ndarray, step: float
) -> np.ndarray:
    """States (m, 2, J) of the modes of second order, m and m/s, as `potential_flow.second_order_states` has them.

    Arguments as of `second_order_surface`; they begin as the liquid's initial swing has them, or at rest.

    Raises:
        ModelError: that swing has more modes than the liquid.
    """
    liquid = driven(cargo)
    begin = np.zeros((2, len(liquid.terms.stiffness)))
    swing = None if cargo.filling is None else cargo.filling.initial_swing
    if swing is not None:
        count = len(swing.second_height)
        if count > begin.shape[1]:
            raise ModelError(
                f"cargo {as_written(cargo.name)}: initial_swing.second_height has {count} modes; its liquid has "
                f"{begin.shape[1]} of second order"
            )
        begin[:, :count] = swing.second_height, swing.second_velocity
    return second_order_states(liquid, _own_rows(cargo, body), displacement, velocity, step, begin)


def _own_rows(cargo: Cargo, body: np.ndarray) -> np.ndarray:
    """Motion (9, m) of an object's bottom centre, in its axes."""
    return rows_at(body, np.array([*cargo.position, 0.0]), cargo.yaw)


def _linear_heights(filling: Filling, body: np.ndarray, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights along x and y (m, 2), and what yaw modes add at most (m,), as `laws.slosh.height` has them."""
    gains = wall_gains(filling.oscillators)
    force = rows_at(body, np.array([0.0, 0.0, filling.liquid_height]))[6:]
    linear = displacement @ gains[:2].T - filling.modes.static_correction * (force[:2] / force[2]).T
    yaw = displacement @ gains[2:].T
    if filling.turns and filling.modes.yaw is not None:
        yaw = yaw - np.outer(body[5] / force[2], filling.modes.yaw.static_correction)
    return linear, np.max(np.abs(yaw), axis=1)
