"""A plan for a range of speeds keeps its limits at all of them; the one for its own speed does not."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

from nospill.certification.certificate import judge_motion
from nospill.certification.other_speeds import uses_at
from nospill.planning.planner import plan
from nospill.planning.task import Task
from nospill.planning.widest_range import range_reached
from nospill.scene.scene import Scene


@pytest.mark.slow
def test_a_cup_at_every_speed_of_a_range(changed_scene: Callable[..., Scene]) -> None:
    scene = changed_scene("pp-two-cups", {"planning.intervals": 40, "planning.starts": 1})
    scene = scene.changed({"cargo": scene.source["cargo"][:1]})
    nominal = plan(scene)
    ranged = plan(scene.changed({"motion.speed_range": [0.85, 0.95]}))
    assert ranged.certificate.ok and ranged.judgement is not None
    assert {row.variant for row in ranged.judgement.corners} >= {"85 % of the speed"}
    speeds = np.random.default_rng(1).uniform(0.85, 0.95, 8)
    most = [
        max(max(use.liquid, use.contact) for use in uses_at(found.trajectory, scene, speeds))
        for found in (nominal, ranged)
    ]
    assert most[0] > 1.1 and most[1] < 1.005
    assert 1.0 < ranged.duration / nominal.duration < 1.1


@pytest.mark.slow
def test_of_a_wider_range_the_part_that_holds_is_named(changed_scene: Callable[..., Scene]) -> None:
    scene = changed_scene("pp-two-cups", {"planning.intervals": 40, "planning.starts": 1})
    ranged = plan(scene.changed({"cargo": scene.source["cargo"][:1], "motion.speed_range": [0.85, 1.0]}))
    wider = ranged.scene.changed({"motion.speed_range": [0.6, 1.0]})
    said = range_reached(ranged.trajectory, judge_motion(ranged.trajectory, wider), Task.of(wider))
    found = re.search(r"certified from ([\d.]+) % of its speed", said)
    assert ranged.certificate.ok and found is not None and 83.0 < float(found[1]) < 86.0
