"""Modes of liquids in a problem that moves them at other speeds too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from nospill.planning.task import Task
from nospill.scene.scene import Scene


def test_slow_liquids_carry_the_modes_that_their_motion_excites(changed_scene: Callable[..., Scene]) -> None:
    """None above twice the frequency of the fastest planned one, on the planned motion's clock; one at least."""
    scene = changed_scene("mixed-tray", {})
    scene = replace(scene, motion=replace(scene.motion, speed_range=(0.2, 1.0)))
    task = Task.of(scene)
    (own,) = (family for family in task.variants if family[0].name == "cup")
    found = task.problem_scene({item.id for item in own}, {"cup"}, 3).cargo
    assert [cargo.speed for cargo in found] == [item.speed for item in own]
    count = [len({mode.frequency for mode in cargo.oscillators}) for cargo in found]
    assert count[0] == 3 and count[-1] == 1 and np.all(np.diff(count) <= 0) and set(count) == {1, 2, 3}
    fastest = max(mode.frequency for mode in found[0].oscillators)
    for cargo, number in zip(found, count, strict=True):
        own_fastest = max(mode.frequency for mode in cargo.oscillators)
        assert own_fastest / cargo.speed <= 2.0 * fastest or number == 1

    kept = task.problem_scene({own[0].id, own[-1].id}, set(), 3).cargo
    assert [len(cargo.oscillators) for cargo in kept] == [1, 1]
