"""The record of one planning task: question, answer, verdict, and the folder they are kept in."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from nospill.approach import Segment, read_segment, segment_text
from nospill.core.files import atomic_folder
from nospill.errors import PlanFolderError
from nospill.export.plan_files import write_plan_files
from nospill.judge.certificate import Judgement
from nospill.judge.verdict import APPROACH, Certificate, Row
from nospill.laws.parameters import flatten
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.motion.trajectory import Trajectory, read_trajectory, trajectory_text
from nospill.scenario import read_scenario, scenario_text, scene_from_table
from nospill.scene.scene import ApproachRules, Scene

SCENARIO_FILE = "scenario.toml"
TRAJECTORY_FILE = "trajectory.csv"
APPROACH_FILE = "approach.csv"
CERTIFICATE_FILE = "certificate.json"
SUMMARY_FILE = "summary.json"

SUMMARY_KEYS = (
    "scenario",
    "status",
    "message",
    "duration_s",
    "plan_time_s",
    "solve_time_s",
    "iterations",
    "starts",
    "max_tray_acceleration_m_s2",
    "max_tray_angular_acceleration_rad_s2",
    "max_tilt_deg",
    "max_joint_speed_use",
    "max_slosh_height_m",
    "residual_slosh_height_m",
    "certificate",
    "rounds",
    "backoff",
    "phases_s",
    "solver_status",
    "branch",
    "base_yaw",
    "approach",
)
"""Keys of the summary, in order; a failed one has them all, null from the duration on."""

_SMALL_ANGLE = 0.01
"""rad; limits below this are shown in thousandths of a radian."""


@dataclass(frozen=True, slots=True)
class MotionMaxima:
    """Largest figures of a motion, as the judge saw it.

    Attributes:
        tray_acceleration: of the tray's centre, m/s^2. tray_angular_acceleration: rad/s^2.
        tilt: of the tray's normal from the vertical, rad.
        joint_speed_use: largest joint speed as a fraction of its limit.
        slosh_height, residual_height: m, per object with liquid.
    """

    tray_acceleration: float
    tray_angular_acceleration: float
    tilt: float
    joint_speed_use: float
    slosh_height: dict[str, float]
    residual_height: dict[str, float]


@dataclass(frozen=True, slots=True)
class Starts:
    """What the starting points led to.

    Attributes:
        tried, converged: counts. agreed: how many ended within 0.5 % of the best.
        durations: end time of each that converged on the coarse grid, s.
    """

    tried: int
    converged: int
    agreed: int
    durations: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PlanningReport:
    """What planning cost.

    Attributes:
        plan_time, solve_time: s. phases: s, by name.
        iterations: of all solves. rounds: of tightening. solver_status: the solver's last word.
        backoff: fraction of the budget kept from the optimiser, by "constraint | subject", where it is above the first.
        branch: the start configuration in words. base_yaw: which one was taken if the scenario left it free, or None.
    """

    plan_time: float
    solve_time: float
    iterations: int
    rounds: int
    starts: Starts
    phases: dict[str, float]
    solver_status: str
    backoff: dict[str, float]
    branch: str = ""
    base_yaw: str | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned motion with its verdict.

    Attributes:
        judgement: the evidence of the certificate while it is at hand; not saved, None for a plan from a folder.
        approach: from where the arm is to the start of the trajectory, if the scenario asks for it. The certificate has
            the rows about it too.
    """

    scene: Scene
    trajectory: Trajectory
    certificate: Certificate
    maxima: MotionMaxima
    report: PlanningReport
    judgement: Judgement | None = field(default=None, repr=False, compare=False)
    approach: Segment | None = field(default=None, repr=False, compare=False)

    @property
    def duration(self) -> float:
        """End time of the motion, s."""
        return self.trajectory.end_time

    @property
    def status(self) -> str:
        """Either "certified" or "uncertified"."""
        return "certified" if self.certificate.ok else "uncertified"

    @property
    def message(self) -> str:
        """One sentence: the verdict and, if it is no, the row that says so."""
        worst = self.certificate.worst
        if self.certificate.ok:
            return f"Certified: {self.duration:.3f} s; nearest to its limit: {describe(worst)}."
        return f"Not certified: {describe(worst)}."

    def summary(self) -> dict[str, Any]:
        """What summary.json holds; the keys are stable."""
        worst, maxima, report = self.certificate.worst, self.maxima, self.report
        return {
            "scenario": self.scene.name,
            "status": self.status,
            "message": self.message,
            "duration_s": self.duration,
            "plan_time_s": report.plan_time,
            "solve_time_s": report.solve_time,
            "iterations": report.iterations,
            "starts": asdict(report.starts),
            "max_tray_acceleration_m_s2": maxima.tray_acceleration,
            "max_tray_angular_acceleration_rad_s2": maxima.tray_angular_acceleration,
            "max_tilt_deg": float(np.degrees(maxima.tilt)),
            "max_joint_speed_use": maxima.joint_speed_use,
            "max_slosh_height_m": maxima.slosh_height,
            "residual_slosh_height_m": maxima.residual_height,
            "certificate": {
                "ok": self.certificate.ok,
                "worst_constraint": f"{worst.constraint} | {worst.label}",
                "worst_margin": worst.worst_margin,
            },
            "rounds": report.rounds,
            "backoff": report.backoff,
            "phases_s": report.phases,
            "solver_status": report.solver_status,
            "branch": report.branch,
            "base_yaw": report.base_yaw,
            "approach": None if self.approach is None else _approach_summary(self.approach),
        }

    def timed(self, phase: str, seconds: float) -> Plan:
        """The same plan with the time of one more phase in its report."""
        return replace(self, report=replace(self.report, phases={**self.report.phases, phase: seconds}))

    def save(
        self, folder: str | Path, *, extra: Callable[[Path], None] | None = None, time_writing: bool = False
    ) -> None:
        """Write the plan folder in one piece: a killed run leaves the old folder or none.

        Args:
            folder: place of the plan folder; an earlier plan there is replaced.
            extra: writes more files into the folder while it is being made, for example figures.
            time_writing: add the time this takes to the summary's phases, so that two copies differ in that figure.

        Raises:
            PlanFolderError: the folder holds something else or cannot be written, or the scene is not what its
                scenario says.
        """
        began = time.perf_counter()
        _require_faithful(self.scene)
        with atomic_folder(folder) as partial:
            _write(partial / SCENARIO_FILE, scenario_text(self.scene))
            _write(partial / TRAJECTORY_FILE, trajectory_text(self.trajectory))
            _write(partial / CERTIFICATE_FILE, _json(self.certificate.to_dict()))
            if self.approach is not None:
                _write(partial / APPROACH_FILE, segment_text(self.approach))
            write_plan_files(self.trajectory, self.scene, partial)
            if extra is not None:
                extra(partial)
            written = self.timed("write", time.perf_counter() - began) if time_writing else self
            _write(partial / SUMMARY_FILE, _json(written.summary()))


def _require_faithful(scene: Scene) -> None:
    """A scene altered in Python no longer agrees with the scenario text that would be kept with the plan."""
    again = scene_from_table(scene.source, name=scene.name)
    same = structure_of(again) == structure_of(scene) and again.motion == scene.motion
    same = same and _same_approach(again.approach, scene.approach)
    same = same and [item.tolerance for item in again.cargo] == [item.tolerance for item in scene.cargo]
    if not same or not np.array_equal(flatten(numbers_of(again)), flatten(numbers_of(scene))):
        raise PlanFolderError(
            f"{scene.name}: the scene was changed after it was read, so the scenario kept with the plan would "
            "contradict it; change the table scene.source and build the scene with nospill.scenario.scene_from_table"
        )


def _same_approach(first: ApproachRules | None, second: ApproachRules | None) -> bool:
    if first is None or second is None:
        return first is second
    return all(np.array_equal(getattr(first, item.name), getattr(second, item.name)) for item in fields(first))


def _approach_summary(segment: Segment) -> dict[str, Any]:
    tray = "loaded" if segment.loaded else "empty"
    return {"file": APPROACH_FILE, "duration_s": segment.duration, "tray": tray, "stretch": segment.stretch}


def failed_summary(scenario: str, message: str) -> dict[str, Any]:
    """The summary of a scenario without a solution: all of `SUMMARY_KEYS`, null from the duration on."""
    return dict.fromkeys(SUMMARY_KEYS) | {"scenario": scenario, "status": "failed", "message": message}


def describe(row: Row) -> str:
    """A certificate row in one phrase: value, limit, how much of it is used, when."""
    factor, unit = shown_unit(row.unit, row.limit)
    value, limit, margin = (
        f"{factor * figure:.4g} {unit}".rstrip() for figure in (row.worst_value, row.limit, abs(row.worst_margin))
    )
    at = f"at t = {row.at_s:.3f} s"
    if row.unit == "1" and row.limit == 1.0:
        return f"{row.constraint} of {row.label} uses {_used(row, 'its limit')} {at}"
    if row.limit == 0.0 or row.constraint.removeprefix(APPROACH) == "joint position":
        distance = f"{margin} {'left' if row.ok else 'beyond'}"
    else:
        distance = _used(row, "it")
    return f"{row.constraint} of {row.label} is {value} against a limit of {limit} ({distance}) {at}"


def shown_unit(unit: str, limit: float = math.inf) -> tuple[float, str]:
    """Factor and name for showing figures of the certificate: mm for m, deg or mrad for rad, % for parts of a capacity.

    Args:
        unit: the row's.
        limit: the row's; small angles are shown in thousandths of a radian, a pure number against another limit than 1
            as it is.
    """
    if unit == "1":
        return (100.0, "%") if limit in (1.0, math.inf) else (1.0, "")
    if unit == "m":
        return 1e3, "mm"
    if unit in ("rad", "rad/s"):
        small = 0.0 < abs(limit) < _SMALL_ANGLE
        return (1e3, f"m{unit}") if small else (180.0 / math.pi, unit.replace("rad", "deg"))
    return 1.0, unit


def _used(row: Row, limit: str) -> str:
    """How much of a limit is used; rounded so that it is 100 % at the very limit only."""
    use = row.use
    if use > 10.0:
        return f"{use:.4g} times {limit}"
    hundredths = math.floor(1e4 * use) if row.ok else math.ceil(1e4 * use)
    return f"{hundredths / 100:.2f} % of {limit}"


def motion_maxima(judgement: Judgement, scene: Scene) -> MotionMaxima:
    """The largest figures of a judged motion."""
    tray = judgement.replay.tray
    largest: dict[str, dict[str, float]] = {}
    for trace in judgement.traces:
        largest.setdefault(trace.constraint, {})[trace.subject] = float(np.max(np.abs(trace.value)))
    speeds = np.abs(judgement.replay.joint_speed) / scene.robot.max_speed
    return MotionMaxima(
        tray_acceleration=float(np.max(np.linalg.norm(tray.acceleration, axis=1))),
        tray_angular_acceleration=float(np.max(np.linalg.norm(tray.angular_acceleration, axis=1))),
        tilt=float(np.max(np.arccos(np.clip(tray.rotation[:, 2, 2], -1.0, 1.0)))),
        joint_speed_use=float(np.max(speeds)),
        slosh_height=largest.get("slosh height", {}),
        residual_height=largest.get("residual height", {}),
    )


def load_plan(folder: str | Path) -> Plan:
    """Read a plan folder; the verdict is the one that was saved, `certify` judges again.

    Raises:
        PlanFolderError: a file is missing or not what nospill wrote. ScenarioError: the scenario in it is not valid.
    """
    place = Path(folder)
    if not place.is_dir():
        raise PlanFolderError(f"{place}: no such folder; make one with nospill plan SCENARIO -o DIR")
    for name in (SCENARIO_FILE, TRAJECTORY_FILE, CERTIFICATE_FILE, SUMMARY_FILE):
        if not (place / name).is_file():
            raise PlanFolderError(f"{place}: not a plan folder: {name} is missing")
    try:
        certificate = json.loads((place / CERTIFICATE_FILE).read_text(encoding="utf-8"))
        summary = json.loads((place / SUMMARY_FILE).read_text(encoding="utf-8"))
        starts = summary["starts"]
        scene = read_scenario(place / SCENARIO_FILE)
        return Plan(
            scene=scene,
            trajectory=read_trajectory(place / TRAJECTORY_FILE),
            certificate=Certificate(
                ok=certificate["ok"],
                grid_hz=certificate["grid_hz"],
                rows=_rows(certificate["rows"]),
            ),
            maxima=MotionMaxima(
                tray_acceleration=summary["max_tray_acceleration_m_s2"],
                tray_angular_acceleration=summary["max_tray_angular_acceleration_rad_s2"],
                tilt=float(np.radians(summary["max_tilt_deg"])),
                joint_speed_use=summary["max_joint_speed_use"],
                slosh_height=summary["max_slosh_height_m"],
                residual_height=summary["residual_slosh_height_m"],
            ),
            report=PlanningReport(
                plan_time=summary["plan_time_s"],
                solve_time=summary["solve_time_s"],
                iterations=summary["iterations"],
                rounds=summary["rounds"],
                backoff=summary["backoff"],
                starts=Starts(starts["tried"], starts["converged"], starts["agreed"], tuple(starts["durations"])),
                phases=summary["phases_s"],
                solver_status=summary["solver_status"],
                branch=summary.get("branch", ""),
                base_yaw=summary.get("base_yaw"),
            ),
            approach=_approach(place, scene, summary),
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        # the repr of an error of decoding holds the whole file
        reason = f"{type(error).__name__}: {error.reason if isinstance(error, UnicodeDecodeError) else error}"[:200]
        raise PlanFolderError(f"{place}: {CERTIFICATE_FILE} or {SUMMARY_FILE} is damaged ({reason})") from error


def _approach(place: Path, scene: Scene, summary: dict[str, Any]) -> Segment | None:
    if scene.approach is None:
        return None
    told = summary["approach"]
    return read_segment(
        place / APPROACH_FILE, scene.robot.joints, loaded=scene.approach.loaded, stretch=float(told["stretch"])
    )


def _rows(found: list[dict[str, Any]]) -> tuple[Row, ...]:
    if not found:
        raise ValueError("a certificate without rows")
    return tuple(Row(**row) for row in found)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _json(value: Any) -> str:
    return json.dumps(value, indent=2, allow_nan=False) + "\n"
