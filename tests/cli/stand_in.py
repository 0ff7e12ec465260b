"""Stand-ins for planner, judge and figures, and the command line called with them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from typer.testing import CliRunner

from nospill.cli import app
from nospill.core.files import atomic_folder
from nospill.errors import PlanFolderError
from nospill.judge.verdict import Certificate, Row
from nospill.plans.names import is_plan_folder
from nospill.plans.plan import SUMMARY_KEYS, failed_summary
from nospill.plans.warnings.record import PlanWarning
from nospill.plots import FIRST_FIGURES


@dataclass
class StandIn:
    """One made-up scene, plan and verdict, and a record of what the command line asked for."""

    ok: bool = True
    planning: Callable[[], None] = lambda: None
    calls: list[str] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)

    figures: tuple[str, ...] | None = None

    duration = 1.8431
    message = "certified"
    motion = SimpleNamespace(hold_before=0.0, hold_after=0.0, speed_range=None)
    robot = SimpleNamespace(name="arm", notes=(), joints=("joint_1", "joint_2"))
    scene = SimpleNamespace(name="tea", robot=robot, motion=motion, path=SimpleNamespace(notes=()), cargo=())
    held_back = "friction of c1 is at its limit for 31 % of the time"
    would_save = "a limit wider by 10 % would save about 0.05 s (friction of all objects)"
    report = SimpleNamespace(branch="start (0, 0) deg", base_yaw=None)
    sooner: tuple[str, ...] = ()
    approach = None
    warnings: tuple[PlanWarning, ...] = ()

    def __post_init__(self) -> None:
        self.rows = [row("slip", "c1", 0.3), row("slip", "c2", 0.1, ok=self.ok), row("slosh height", "[c1]", 1e-5)]

    @property
    def certificate(self) -> Certificate:
        return Certificate(ok=self.ok, grid_hz=2000.0, rows=tuple(self.rows))

    def summary(self) -> dict[str, Any]:
        return {key: None for key in SUMMARY_KEYS} | {"status": "certified" if self.ok else "uncertified"}

    def timed(self, phase: str, seconds: float) -> StandIn:
        assert phase == "import" and seconds >= 0.0
        return self

    def with_second_looks(self) -> StandIn:
        return self

    def save(self, folder: Path, extra: Callable[[Path], None] | None = None, time_writing: bool = False) -> None:
        with atomic_folder(folder, replaceable=is_plan_folder) as partial:
            (partial / "summary.json").write_text(json.dumps(self.summary()))
            if extra is not None:
                extra(partial)

    def modules(self) -> dict[str, ModuleType]:
        def read_scenario(path: str, *, settings: Sequence[str] = ()) -> SimpleNamespace:
            self.calls.append(" ".join([f"read {path}", *settings]))
            return self.scene

        def plan(scene: SimpleNamespace, *, progress: Callable[[Any], None]) -> StandIn:
            self.calls.append("plan")
            for phase, iteration in (("build", None), ("solve", 1), ("solve", 2), ("certify", None)):
                progress(SimpleNamespace(phase=phase, iteration=iteration, duration_s=1.9, violation=1e-3, stage=""))
            self.planning()
            return self

        def load_plan(folder: Path) -> SimpleNamespace:
            if not (folder / "summary.json").exists():
                raise PlanFolderError(f"{folder} is not a plan folder")
            report = SimpleNamespace(backoff={})
            return SimpleNamespace(trajectory="trajectory", scene=self.scene, report=report)

        def judge_whole(saved: SimpleNamespace) -> SimpleNamespace:
            self.calls.append(f"judge {saved.trajectory} {saved.scene.name}")
            return SimpleNamespace(certificate=self.certificate)

        def plan_warnings(scene: object, judgement: object, backoff: object) -> tuple[PlanWarning, ...]:
            return self.warnings

        def save_figures(
            plan: object,
            folder: Path,
            *,
            names: tuple[str, ...] = (),
            pdf: bool = False,
            progress: Callable[[int, int], None] | None = None,
        ) -> None:
            self.figures = names
            folder.mkdir(exist_ok=True)
            assert progress is not None
            progress(0, 1)
            if pdf:
                (folder / "sheet.pdf").write_text("new")
            (folder / "sheet.png").write_text("new")

        functions = {
            "scenario": {"read_scenario": read_scenario},
            "planning.planner": {"plan": plan},
            "plans.plan": {"failed_summary": failed_summary},
            "plans.loading": {"load_plan": load_plan},
            "plans.approach": {"judge_whole": judge_whole},
            "plans.settling": {"settling_time": lambda *_: 0.0, "AFTER_APPROACH": ""},
            "plans.warnings": {"plan_warnings": plan_warnings},
            "plans.warnings.speeds": {"other_speeds": lambda *_: ()},
            "judge.other_speeds": {"uses_at": lambda *_: ()},
            "plots": {"save_figures": save_figures, "FIRST_FIGURES": FIRST_FIGURES},
        }
        modules = {f"nospill.{name}": ModuleType(f"nospill.{name}") for name in functions}
        for name, attributes in functions.items():
            vars(modules[f"nospill.{name}"]).update(attributes)
        return modules


def row(constraint: str, subject: str, margin: float, *, ok: bool = True) -> Row:
    return Row(
        constraint=constraint,
        subject=subject,
        unit="N",
        limit=1.0,
        worst_value=1.0 - margin,
        worst_margin=margin,
        at_s=0.5,
        ok=ok,
    )


def nospill(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False, prog_name="nospill")


def raising(error: BaseException) -> Callable[[], None]:
    def fail() -> None:
        raise error

    return fail
