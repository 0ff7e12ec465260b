"""Which motions turn what stands on the tray about its own axis, and the liquids whose yaw modes this excites.

A tray that stays level with a constant yaw never does. Any other may: the yaw of the path changes, the tray turns as it
likes, or pitch and roll together turn it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.paths.path import Path
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_content
from nospill.scene.scene import MotionRules

_NO_TURN = 1e-9
"""A coefficient of the yaw, in rad and powers of s, that is rounding."""


def turns(path: Path, motion: MotionRules) -> bool:
    """Whether a motion turns what stands on the tray about its own axis."""
    if motion.tilt_free or motion.yaw_free or path.joint_curve is not None:
        return True
    changing = path.coefficients[:-1, :, 3]  # of a path without jumps: the constants of its pieces are then alike
    return bool(np.max(np.abs(changing), initial=0.0) > _NO_TURN)


def turning(cargo: Cargo, *, on: bool = True) -> Cargo:
    """The object with its yaw modes, or without them; as it is where it has none, in a carrier those of its liquids."""
    if cargo.contents is not None:
        content = tuple(turning(item, on=on) for item in cargo.contents.content)
        same = all(a is b for a, b in zip(content, cargo.contents.content, strict=True))
        return cargo if same else with_content(cargo, content, cargo.empty)
    filling = cargo.filling
    if filling is None or filling.modes.yaw is None or filling.turns == on:
        return cargo
    return replace(cargo, filling=replace(filling, turns=on))
