"""What a plan rests on beyond its limits: warnings, one function each, in one table.

A warning leaves the verdict as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nospill.certification.certificate import Judgement
from nospill.certification.other_speeds import SpeedUse
from nospill.plans.warnings.arm import (
    below_the_base,
    doubts,
    estimated_touch,
    no_joint_acceleration_limit,
    no_mass,
    self_collision_off,
)
from nospill.plans.warnings.controller import behind_the_command, deviation_from_command
from nospill.plans.warnings.fallbacks import fallback
from nospill.plans.warnings.liquids import (
    breaking,
    contact_angle,
    contact_line,
    crest,
    damping,
    density,
    distance_to_the_rim,
    driven_by_turns,
    meniscus,
    sloping_wall,
    surface_tension,
    surface_tension_value,
    viscosity,
)
from nospill.plans.warnings.nonlinear_flow import flow, flow_in_doubt
from nospill.plans.warnings.objects import empty_tray, hardly_meant
from nospill.plans.warnings.record import Facts, PlanWarning, Warn
from nospill.plans.warnings.reserves import back_off, no_reserve
from nospill.plans.warnings.second_order import second_order
from nospill.plans.warnings.smoothness import smoothness
from nospill.plans.warnings.speeds import other_speeds
from nospill.scene.scene import Scene

WARNINGS: tuple[Warn, ...] = (
    fallback,
    doubts,
    crest,
    breaking,
    driven_by_turns,
    flow,
    flow_in_doubt,
    sloping_wall,
    distance_to_the_rim,
    surface_tension,
    contact_line,
    contact_angle,
    meniscus,
    damping,
    density,
    viscosity,
    surface_tension_value,
    no_joint_acceleration_limit,
    no_mass,
    empty_tray,
    hardly_meant,
    below_the_base,
    self_collision_off,
    estimated_touch,
    behind_the_command,
    deviation_from_command,
    no_reserve,
    back_off,
    smoothness,
)
"""Every warning that costs nothing beside a plan, in the order in which they are shown; `slower_warnings` follow."""


def plan_warnings(
    scene: Scene, judgement: Judgement, backoff: Mapping[str, float], fallbacks: Sequence[str] = ()
) -> tuple[PlanWarning, ...]:
    """All warnings about a judged motion.

    Args:
        scene: the task.
        judgement: of the motion, with its replay.
        backoff: fraction of the budget kept from the optimiser, by "constraint | subject".
        fallbacks: what planning took in the place of what was asked for, a sentence each.
    """
    facts = Facts(scene, judgement, backoff, fallbacks)
    return tuple(warning for warn in WARNINGS for warning in warn(facts))


def slower_warnings(
    scene: Scene,
    judgement: Judgement,
    full: Judgement,
    uses: Sequence[SpeedUse],
    speed_range: tuple[float, float] | None,
) -> tuple[PlanWarning, ...]:
    """Warnings that take longer than a warm plan: for a motion that is saved, printed or reported.

    Args:
        scene: the task.
        judgement: of the motion, with its replay.
        full: of the same motion in the full model, as `judged_in_full` has it.
        uses: of the limits at lower speeds.
        speed_range: where a certificate holds, None without one.
    """
    return (*second_order(Facts(scene, judgement, {}), full), *other_speeds(uses, speed_range))
