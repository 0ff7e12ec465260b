"""Scenes with an approach, and where their motion starts; no solver is involved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from nospill.robots.joint_paths.search import preferred_path
from nospill.scene.scene import ApproachRules, Scene
from tests.builders import joint_path_of, joint_paths_of


@dataclass(frozen=True)
class Requested:
    """A scene that asks for an approach, its rules, and the joints at which the motion starts."""

    scene: Scene
    rules: ApproachRules
    end: np.ndarray


@pytest.fixture(scope="session")
def requested(changed_scene) -> Callable[..., Requested]:
    """Make the scene of an example with a table [approach]; `shift` (rad) is taken from the start of the motion."""

    @cache
    def start(name: str) -> np.ndarray:
        scene = changed_scene(name, {})
        return joint_path_of(scene).q[0]

    def make(name: str = "matrix-liquid", *, shift: list[float] | None = None, **table: Any) -> Requested:
        own = start(name)
        came = "home" if shift is None else [float(value) for value in own + np.array(shift)]
        entry = {"from": came, "tray": "empty", "acceleration": "6 rad/s^2"} | table
        scene = changed_scene(name, {"approach": entry})
        assert scene.approach is not None
        if shift is None:
            own = preferred_path(joint_paths_of(scene), scene.robot, scene.start_near).q[0]
        return Requested(scene, scene.approach, own)

    return make
