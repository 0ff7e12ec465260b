"""The wait until the liquids are at rest: against the free motion, played on in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.after_end import free_heights
from nospill.certification.certificate import judge
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.residual import free_states
from nospill.plans.plan import Plan
from nospill.plans.settling import settling_time


def test_after_the_wait_the_surface_stays_below_two_per_cent_and_shortly_before_it_does_not(smooth_motion) -> None:
    motion = smooth_motion("matrix-liquid-soft-end", cargo=1, stretch=0.9)
    judgement = judge(motion.trajectory, motion.scene)
    wait = settling_time(motion.scene, judgement.certificate)
    cargo = motion.scene.cargo[0]
    assert cargo.filling is not None and wait > 1.0
    (mode,) = cargo.oscillators
    q, qd = judgement.replay.slosh_displacement[-1], judgement.replay.slosh_velocity[-1]
    frequency, damping = np.full(2, mode.frequency), np.full(2, mode.damping)
    later = np.arange(0.0, wait + 5.0, 1e-3)
    heights = free_heights(
        structure_of(motion.scene).objects[0],
        numbers_of(motion.scene).objects[0],
        free_states(frequency, damping, q, qd, later)[0],
    )
    still = 0.02 * cargo.filling.max_slosh_height
    assert heights[later >= wait].max() <= 1.001 * still
    assert heights[(later >= 0.9 * wait) & (later < wait)].max() > 0.9 * still


@pytest.mark.slow
def test_a_summary_says_it_and_liquids_without_damping_never_rest(gentle_plan) -> None:
    plan: Plan = gentle_plan("matrix-liquid-soft-end", 1)
    assert plan.summary()["settling_s"] == pytest.approx(settling_time(plan.scene, plan.certificate))
    first, *others = plan.scene.cargo
    assert first.filling is not None
    undamped = tuple(replace(mode, damping=0.0) for mode in first.filling.modes.oscillators)
    modes = replace(first.filling.modes, oscillators=undamped)
    scene = replace(plan.scene, cargo=(replace(first, filling=replace(first.filling, modes=modes)), *others))
    assert settling_time(scene, plan.certificate) == np.inf
    assert replace(plan, scene=scene).summary()["settling_s"] is None
