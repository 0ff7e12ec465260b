"""What a report says, before it is HTML or PDF."""

from __future__ import annotations

import hashlib
import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from nospill.certification.full_model import judged_in_full
from nospill.certification.height_order import height_sentence
from nospill.certification.verdict import Certificate
from nospill.certification.wording import describe, finding, full_model_note, integrity_line, row_text
from nospill.execution.executed import Executed
from nospill.motion.trajectory import trajectory_text
from nospill.plans.approach import judged
from nospill.plans.plan import Plan
from nospill.plans.warnings import plan_warnings, slower_warnings
from nospill.plans.warnings.record import warning_rows
from nospill.plots.evidence import Evidence, evidence_of
from nospill.plots.text_pages import TextTable
from nospill.plots.tiles import Tile, liquid_tiles, tiles
from nospill.report.executed_run import ExecutedRun, executed_run
from nospill.report.second_opinion import NOT_ASKED, SecondOpinion
from nospill.report.task import cargo_table, joint_table, task_table

NOT_PROVEN = (
    ("That the robot does it", "The commanded motion is judged. Tracking error, filters in a controller and a tray "
     "that bends come on top."),
    ("That the numbers are right", "Friction, fill heights, masses and frames are believed as the scenario gives them; "
     "nospill margins DIR says what is left when they are off."),
    ("What is not a row", "Collisions where the scenario states no obstacles, and any joint quantity that has no row "
     "in the table, are not judged."),
    ("The liquid beyond its model", "A linear surface is believed up to about a third of the radius: no breaking "
     "waves, drops, foam or floating things."),
    ("Contact beyond the model", "A flat footprint, pressed linearly, and Coulomb friction with one coefficient: "
     "no warped tray, vibration or sticking."),
    ("Between the instants", "Every limit is checked on a grid of 2 kHz or more, and very likely "
     "holds between its points, too."),
    ("That nothing faster exists", "The verdict is about limits, not about optimality."),
)  # fmt: skip
"""What a certificate leaves open: in short, and in one sentence."""

_PACKAGES = ("nospill", "casadi", "numpy", "scipy", "matplotlib")


@dataclass(frozen=True, slots=True)
class Report:
    """All that a report says.

    Attributes:
        evidence: the plan and the judgement the report rests on; figures are drawn from it.
        ok, verdict, detail: whether it is certified, in two or three words, and in one sentence.
        tiles: largest figures.
        opinion: of the simulation.
        checksum: SHA-256 of trajectory.csv, hexadecimal.
        task, cargo, joints, planning, versions: tables.
        warnings: what the verdict rests on: what about, subject, sentence.
        executed: what a log of the motion says, if there is one.
        stops: what happens if it is stopped, where somebody has looked.
    """

    evidence: Evidence
    ok: bool
    verdict: str
    detail: str
    tiles: tuple[Tile, ...]
    opinion: SecondOpinion
    checksum: str
    task: TextTable
    cargo: TextTable
    joints: TextTable
    planning: TextTable
    versions: TextTable
    warnings: TextTable
    executed: ExecutedRun | None = None
    stops: TextTable | None = None

    @property
    def certificate(self) -> Certificate:
        """As judged for this report."""
        return self.evidence.judgement.certificate


def make_report(
    plan: Plan,
    *,
    opinion: SecondOpinion = NOT_ASKED,
    controller_files: Mapping[str, str | None] | None = None,
    executed: Executed | None = None,
    stops: TextTable | None = None,
) -> Report:
    """Put a report together; the motion is judged again unless the plan has its judgement at hand.

    Args:
        plan: certified or not.
        opinion: of a simulation.
        executed: a log of the motion, judged.
        stops: as `read_stopping_table` has it.
        controller_files: by name, what is wrong with it or None, as `export.plan_files.compare_plan_files` says.

    Raises:
        ModelError: the liquids cannot be integrated along the trajectory.
        PlanFolderError: the trajectory does not fit the scene.
    """
    evidence = evidence_of(plan, judged(plan))
    scene, certificate = evidence.plan.scene, evidence.judgement.certificate
    failed = [row for row in certificate.rows if not row.ok]
    grid = f"at {certificate.grid_hz:g} instants per second"
    if certificate.ok:
        detail = f"All {len(certificate.rows)} rows hold, {grid}. Nearest to its limit: {describe(certificate.worst)}."
    else:
        detail = f"{len(failed)} of {len(certificate.rows)} rows fail, {grid}. First of all: {finding(certificate)}."
    digest = hashlib.sha256(trajectory_text(plan.trajectory).encode()).hexdigest()
    return Report(
        evidence=evidence,
        ok=certificate.ok,
        verdict=certificate.word,
        detail=detail + height_sentence(scene) + _beyond(certificate) + _left(plan) + _survives(plan),
        tiles=tuple(dict.fromkeys((*tiles(evidence), *liquid_tiles(evidence)))),
        opinion=opinion,
        checksum=digest,
        task=task_table(scene, approach=plan.approach),
        cargo=cargo_table(scene, certificate),
        joints=joint_table(scene, plan.trajectory, certificate),
        planning=_planning(plan),
        versions=_versions(plan, digest, controller_files or {}),
        warnings=_warnings(evidence),
        executed=None if executed is None else executed_run(executed),
        stops=stops,
    )


def _beyond(certificate: Certificate) -> str:
    """What the full model sees beyond the limits, as a sentence; empty where it sees nothing."""
    note = full_model_note(certificate)
    if not note:
        return ""
    by = "Judged by the published equations; " if certificate.published else ""
    return f" {by}{note if by else note[:1].upper() + note[1:]}."


def _left(plan: Plan) -> str:
    """What is left of the liquids' waves after the end, as a sentence; empty where nobody has looked."""
    text = plan.left_text
    return f" {text[:1].upper()}{text[1:]}." if text else ""


def _survives(plan: Plan) -> str:
    """What the motion survives of its arm, as a sentence; empty where nobody has looked."""
    text = plan.survival_text
    return f" It {text}." if text else ""


def certificate_table(certificate: Certificate, *, everything: bool) -> TextTable:
    """The certificate as text: the fullest row of every constraint, the fullest first, or all rows in their order."""
    rows = certificate.rows if everything else certificate.listed_rows()
    cells = []
    for row in rows:
        text = row_text(row)
        verdict = "holds" if row.ok else "FAILS"
        cells.append((row.constraint, row.label, text.use, text.value, text.limit, text.unit, text.at, verdict))
    return TextTable(
        "All rows of the certificate" if everything else "Certificate",
        ("constraint", "of", "use of limit", "value", "limit", "unit", "at [s]", ""),
        tuple(cells),
        note="" if everything else f"{integrity_line(certificate).capitalize()}.",
        failing=tuple(index for index, row in enumerate(rows) if not row.ok),
    )


def _warnings(evidence: Evidence) -> TextTable:
    plan = evidence.plan
    found = plan_warnings(plan.scene, evidence.judgement, plan.report.backoff, plan.report.fallbacks)
    speeds = evidence.other_speeds[:-1], plan.certified_speeds
    full = judged_in_full(evidence.judgement, plan.trajectory, plan.scene)
    found = (*found, *slower_warnings(plan.scene, evidence.judgement, full, *speeds))
    rows = tuple(warning_rows(found))
    return TextTable(
        "Warnings", ("what", "of", "why"), rows or (("none", "", ""),), note="They leave the verdict as it is."
    )


def _planning(plan: Plan) -> TextTable:
    report = plan.report
    phases = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in report.phases.items())
    starts = report.starts
    durations = ", ".join(f"{duration:.3f} s" for duration in starts.durations)
    rows = [
        ("planning", f"{report.plan_time:.2f} s, of which {report.solve_time:.2f} s in the solver"),
        ("phases", phases),
        ("starts", f"{starts.tried} tried, {starts.converged} converged, {starts.agreed} agree within 0.5 %"),
        ("on the coarse grid", durations),
        ("branch", report.branch),
        ("base yaw, left free", report.base_yaw or ""),
        ("yaw of the tray, left free", report.end_yaws or ""),
        ("direct way, blocked", report.blocked_way),
        ("iterations", str(report.iterations)),
        ("rounds", f"{report.rounds} of tightening what the judge objected to"),
        *((f"back-off, {name}", f"{100 * share:.2f} % kept back") for name, share in report.backoff.items()),
        ("solver", report.solver_status + ("; the time planning.max_plan_time was up" if report.ran_out else "")),
        ("linear solver", _in_words(report.linear_solvers)),
    ]
    return TextTable("How it was planned", (), tuple((name, text) for name, text in rows if text))


def _in_words(names: Sequence[str]) -> str:
    """The most frequent name, then how often there was another."""
    (first, _), *others = Counter(names).most_common() or [("", 0)]
    return "; ".join([first, *(f"{name} in {count} of {len(names)} solves" for name, count in others)])


def _versions(plan: Plan, digest: str, controller_files: Mapping[str, str | None]) -> TextTable:
    rows = [("trajectory.csv", f"{len(plan.trajectory.t)} samples, SHA-256 {digest[:16]}…{digest[-8:]}")]
    rows += [(name, fault or "holds the motion of trajectory.csv") for name, fault in controller_files.items()]
    rows += [(name, _version(name)) for name in _PACKAGES]
    rows.append(("Python", f"{platform.python_version()} on {platform.system()}"))
    failing = tuple(index for index, (name, _) in enumerate(rows) if controller_files.get(name))
    return TextTable("Files and versions", (), tuple(rows), note="Versions: of what made this report.", failing=failing)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed as a package"
