"""Reading a plan folder."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nospill.approach import Segment, read_segment
from nospill.certification.height_order import SECOND
from nospill.certification.verdict import Certificate, Row
from nospill.collisions.pairs import SelfCollision
from nospill.core.files import parsed_json
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.constraints import constrained
from nospill.laws.constraints.base import Constraint
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.motion.trajectory import read_trajectory
from nospill.plans.approach import judge_whole
from nospill.plans.names import (
    APPROACH_FILE,
    CERTIFICATE_FILE,
    CYCLE_FILE,
    LEGS_FOLDER,
    SCENARIO_FILE,
    SUMMARY_FILE,
    TRAJECTORY_FILE,
)
from nospill.plans.plan import Plan
from nospill.plans.summary import restored_records
from nospill.plans.warnings.record import PlanWarning
from nospill.scenario import read_scenario
from nospill.scene.heights import HeightOrder, by_nonlinear_flow
from nospill.scene.limits import LimitRecord
from nospill.scene.scene import Scene


def load_plan(folder: str | Path, *, constraints: Iterable[Constraint] | None = None) -> Plan:
    """Read a plan folder; the verdict is the one that was saved, `certify` judges again.

    Args:
        folder: that `Plan.save` or `nospill plan -o` wrote.
        constraints: limits of your own classes, by which the motion is judged again. A plan that was saved with one
            that is not among them is not certified: the folder has its name and numbers, not its law.

    Raises:
        PlanFolderError: a file is missing or not what nospill wrote. ScenarioError: the scenario in it is not valid; a
            constraint is none, is about nothing in the scene or fails.
    """
    plan = _read(folder, constraints)
    if constraints is None:
        return plan
    verdict = judge_whole(plan)
    return replace(plan, certificate=replace(verdict.certificate, full_model=plan.certificate.full_model))


def _read(folder: str | Path, constraints: Iterable[Constraint] | None) -> Plan:
    """The plan with its saved verdict; raises the same."""
    place = Path(folder)
    if place.is_file():
        raise PlanFolderError(f"{place}: is a file; give the folder that holds the plan")
    if not place.is_dir():
        raise PlanFolderError(f"{place}: no such folder; make one with nospill plan SCENARIO -o DIR")
    if (place / CYCLE_FILE).is_file():
        legs = sorted(leg.name for leg in (place / LEGS_FOLDER).glob("*") if leg.is_dir())
        named = f", as {place / LEGS_FOLDER / legs[0]}" if legs else ""
        raise PlanFolderError(f"{place}: holds a cycle, and one motion is meant here: name the folder of a leg{named}")
    for name in (SCENARIO_FILE, TRAJECTORY_FILE, CERTIFICATE_FILE, SUMMARY_FILE):
        if not (place / name).is_file():
            raise PlanFolderError(f"{place}: not a plan folder: {name} is missing")
    try:
        certificate = parsed_json((place / CERTIFICATE_FILE).read_text(encoding="utf-8-sig"))
        summary = parsed_json((place / SUMMARY_FILE).read_text(encoding="utf-8-sig"))
        maxima, report = restored_records(summary)
        unjudged = _limits_not_at_hand(summary)
        read = _rows(certificate["rows"])
        orders = dict(summary.get("slosh_height_order", {}))  # of a damaged one there is none
        scene = constrained(as_certified(read_scenario(place / SCENARIO_FILE), read, orders), constraints)
        names = {limit.name for limit in scene.constraints}
        scene = scene.with_constraints(scene.constraints, [limit for limit in unjudged if limit.name not in names])
        known = names.union(limit.name for limit in unjudged)
        return Plan(
            scene=scene,
            trajectory=replace(read_trajectory(place / TRAJECTORY_FILE), in_motion=scene.initial_state is not None),
            certificate=Certificate(
                ok=certificate["ok"] and not scene.unjudged,
                grid_hz=certificate["grid_hz"],
                rows=_some([row for row in read if row.constraint not in known]),
                published=bool(certificate.get("published", False)),
                modes=certificate.get("modes"),
                full_model=_failing_rows(certificate),
                unjudged=scene.unjudged,
                self_collision=_self_collision(certificate),
            ),
            maxima=maxima,
            report=report,
            approach=_approach(place, scene, summary),
            warnings=tuple(PlanWarning(**entry) for entry in summary.get("warnings", ())),
        )
    except (OSError, ValueError, KeyError, TypeError, OverflowError) as error:
        # the repr of an error of decoding holds the whole file
        reason = f"{type(error).__name__}: {error.reason if isinstance(error, UnicodeDecodeError) else error}"[:200]
        raise PlanFolderError(f"{place}: {CERTIFICATE_FILE} or {SUMMARY_FILE} is damaged ({reason})") from error


def as_certified(scene: Scene, rows: Iterable[Row], orders: Mapping[str, str]) -> Scene:
    """The scene of saved rows, with heights of their order where that is lower and the scenario does not say it.

    What is left out was linear after the end in earlier versions, and of second order during the motion; a folder is
    about what it was certified for.

    Args:
        scene: of the folder's scenario.
        rows: of its certificate.
        orders: of slosh heights, by object, as its summary has them.
    """
    rules, stated = scene.motion, scene.source.get("motion", {})

    def followed(order: HeightOrder) -> set[str]:
        return {item.name for item in scene.cargo if not rules.stop and by_nonlinear_flow(item, order)}

    linear = {row.subject for row in rows if row.constraint == ResidualHeight.name and row.linear_value is None}
    if stated.get("residual_height") is None and linear & followed(rules.residual_height):
        return scene.changed({"motion.residual_height": "linear"})
    second = {name for name, order in orders.items() if order == SECOND}
    if stated.get("slosh_height") is None and second & followed(rules.slosh_height):
        return scene.changed({"motion.slosh_height": "second order"})
    return scene


def _self_collision(certificate: Mapping[str, Any]) -> SelfCollision | None:
    """What the certificate says of the arm with itself; None where an earlier version wrote it."""
    found = certificate.get("self_collision")
    return None if found is None else SelfCollision.from_dict(found)


def require_no_own_limits(scenario: str | Path) -> None:
    """Refuse to plan the scenario of a plan folder again without the limits that it was planned with.

    Raises:
        ScenarioError: the folder names limits of classes in Python; its scenario file says nothing of them.
    """
    file = Path(scenario) / SUMMARY_FILE
    if not file.is_file():
        return
    try:
        names = [limit.name for limit in _limits_not_at_hand(parsed_json(file.read_text(encoding="utf-8-sig")))]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return  # whoever needs the summary says what is wrong with it
    if names:
        raise ScenarioError(
            f"{scenario}: this plan has limits of your own classes ({', '.join(names)}), which no command knows; plan "
            f"from Python with constraints=[...], or name {Path(scenario) / SCENARIO_FILE} to plan without them"
        )


def _limits_not_at_hand(summary: dict[str, Any]) -> list[LimitRecord]:
    """Limits from Python that the plan was saved with; an older one has none."""
    return [LimitRecord.of(entry) for entry in summary.get("constraints", ())]


def _approach(place: Path, scene: Scene, summary: dict[str, Any]) -> Segment | None:
    if scene.approach is None:
        return None
    recorded = summary["approach"]
    return read_segment(
        place / APPROACH_FILE, scene.robot.joints, loaded=scene.approach.loaded, stretch=float(recorded["stretch"])
    )


def _failing_rows(certificate: dict[str, Any]) -> tuple[Row, ...] | None:
    found = certificate.get("full_model")
    return None if found is None else tuple(Row(**row) for row in found)


def _rows(found: list[dict[str, Any]]) -> tuple[Row, ...]:
    return _some([Row(**row) for row in found])


def _some(rows: list[Row]) -> tuple[Row, ...]:
    if not rows:
        raise ValueError("a certificate without rows")
    return tuple(rows)
