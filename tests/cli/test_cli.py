"""The command line, with stand-ins for planner, judge and figures: what it prints where, and with which exit code."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from nospill.cli import app
from nospill.core.files import atomic_folder
from nospill.errors import NoSolutionError, PlanFolderError, ScenarioError
from nospill.judge.verdict import Certificate, Row
from nospill.plans.plan import SUMMARY_KEYS, failed_summary

# fmt: off
COMMANDS = (
    "plan", "check", "verify", "margins", "plot", "view", "studio", "report", "export", "simulate", "compare",
    "examples", "robots", "schema",
)
# fmt: on


@dataclass
class StandIn:
    """One made-up scene, plan and verdict, and a record of what the command line asked for."""

    ok: bool = True
    planning: Callable[[], None] = lambda: None
    calls: list[str] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)

    duration = 1.8431
    message = "certified"
    motion = SimpleNamespace(hold_before=0.0, hold_after=0.0)
    scene = SimpleNamespace(name="tea", robot=SimpleNamespace(name="arm", notes=()), motion=motion)
    report = SimpleNamespace(branch="start (0, 0) deg", base_yaw=None)
    approach = None

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

    def save(self, folder: Path, extra: Callable[[Path], None] | None = None, time_writing: bool = False) -> None:
        with atomic_folder(folder) as partial:
            (partial / "summary.json").write_text(json.dumps(self.summary()))
            if extra is not None:
                extra(partial)

    def modules(self) -> dict[str, ModuleType]:
        def read_scenario(path: str) -> SimpleNamespace:
            self.calls.append(f"read {path}")
            return self.scene

        def plan(scene: SimpleNamespace, *, progress: Callable[[Any], None]) -> StandIn:
            self.calls.append("plan")
            for phase, iteration in (("build", None), ("solve", 1), ("solve", 2), ("certify", None)):
                progress(SimpleNamespace(phase=phase, iteration=iteration, duration_s=1.9, violation=1e-3))
            self.planning()
            return self

        def load_plan(folder: Path) -> SimpleNamespace:
            if not (folder / "summary.json").exists():
                raise PlanFolderError(f"{folder} is not a plan folder")
            return SimpleNamespace(trajectory="trajectory", scene="scene")

        def certify_whole(saved: SimpleNamespace) -> Certificate:
            self.calls.append(f"certify {saved.trajectory} {saved.scene}")
            return self.certificate

        def save_figures(plan: object, folder: Path) -> None:
            folder.mkdir(exist_ok=True)
            (folder / "sheet.png").write_text("new")

        functions = {
            "scenario": {"read_scenario": read_scenario},
            "planning.planner": {"plan": plan},
            "plans.plan": {"failed_summary": failed_summary},
            "plans.loading": {"load_plan": load_plan},
            "plans.approach": {"certify_whole": certify_whole, "settling_time": lambda _: 0.0},
            "plots": {"save_figures": save_figures},
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


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    made = StandIn()
    for name, module in made.modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    return made


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NOSPILL_TRACEBACK", raising=False)
    return tmp_path


def nospill(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False, prog_name="nospill")


def raising(error: BaseException) -> Callable[[], None]:
    def fail() -> None:
        raise error

    return fail


@pytest.fixture
def outside(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """The command in a process of its own, with the stand-ins and a line of code as the planner's work."""
    started: list[subprocess.Popen[str]] = []

    def start(work: str, *arguments: str) -> subprocess.Popen[str]:
        script = (
            f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
            "import ctypes, os, time, test_cli\n"
            f"def work():\n    {work}\n"
            "sys.modules.update(test_cli.StandIn(planning=work).modules())\n"
            "from nospill.cli import main\n"
            "main()\n"
        )
        process = subprocess.Popen(
            [sys.executable, "-c", script, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


# --- plan -----------------------------------------------------------------------------------------------------------


def test_certified_plan_is_written_with_its_figures(stand_in: StandIn, folder: Path) -> None:
    result = nospill("plan", "tea.toml", "-o", "out/tea")
    assert result.exit_code == 0
    assert stand_in.calls == ["read tea.toml", "plan"]
    assert sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()) == [
        "out/tea/figures/sheet.png",
        "out/tea/summary.json",
    ]
    for expected in ("certified: all 3 rows hold on a grid of 2000 Hz", "duration: 1.843 s", "written to out/tea"):
        assert expected in result.stdout
    assert result.stderr.splitlines() == [
        "load the optimiser ...",
        "build ...",
        "solve ...",
        "certify ...",
        "write ...",
    ]


@pytest.mark.parametrize("ok", [True, False])
def test_report_of_a_plan_certified_or_not(
    stand_in: StandIn, folder: Path, ok: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(found: StandIn, place: Path) -> Path:
        assert found is stand_in and (place / "summary.json").exists()  # the plan is safe before the report is made
        return place.with_name("tea.report.html")

    monkeypatch.setattr("nospill.cli.planning.write_plan_report", write)
    stand_in.ok = ok
    stand_in.rows[1] = row("slip", "c2", 0.1, ok=ok)
    result = nospill("plan", "tea.toml", "-o", "out/tea", "--report")
    assert result.exit_code == (0 if ok else 1)
    assert result.stdout.splitlines()[-1] == "written to out/tea.report.html"
    assert nospill("plan", "tea.toml", "-o", "out/tea", "--report", "--json").stdout.startswith("{")


def test_report_without_a_folder_plans_nothing(stand_in: StandIn) -> None:
    result = nospill("plan", "tea.toml", "--report")
    assert result.exit_code == 2 and "name one with -o DIR" in result.stderr
    assert stand_in.calls == []


def test_table_shows_the_worst_row_of_each_constraint(stand_in: StandIn) -> None:
    stand_in.rows.append(row("slip", "c9", -5.0, ok=True))
    stand_in.rows.append(row("slip", "c3", 0.2, ok=False))
    stand_in.ok = False
    result = nospill("plan", "tea.toml")
    lines = result.stdout.splitlines()
    slip = [line.split() for line in lines if line.strip().startswith("slip")]
    assert slip == [["slip", "c3", "0.8", "1", "0.2", "N", "0.5", "FAILS"]]
    assert any("[c1]" in line and "1e-05" in line for line in lines)
    assert "not certified: 1 of 5 rows fail" in result.stdout


def test_without_folder_nothing_is_written(stand_in: StandIn, folder: Path) -> None:
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 0
    assert "nothing written; -o DIR keeps the plan" in result.stdout
    assert list(folder.iterdir()) == []


def test_without_figures(stand_in: StandIn, folder: Path) -> None:
    assert nospill("plan", "tea.toml", "-o", "tea", "--no-figures").exit_code == 0
    assert os.listdir(folder / "tea") == ["summary.json"]


def test_uncertified_plan_is_kept_and_exits_1(stand_in: StandIn, folder: Path) -> None:
    stand_in.ok = False
    stand_in.message = "slip of c2 fails\nby 0.1 N"
    result = nospill("plan", "tea.toml", "-o", "tea")
    assert result.exit_code == 1
    assert (folder / "tea" / "summary.json").exists()
    assert result.stderr.splitlines()[-1] == "slip of c2 fails by 0.1 N"


@pytest.mark.parametrize("ok", [True, False])
def test_json_is_the_summary_alone(stand_in: StandIn, ok: bool) -> None:
    stand_in.ok = ok
    result = nospill("plan", "tea.toml", "--json", "-o", "tea")
    assert result.exit_code == (0 if ok else 1)
    assert json.loads(result.stdout) == stand_in.summary()


def test_json_stays_clean_whatever_the_solvers_print(outside: Callable[..., subprocess.Popen[str]]) -> None:
    work = "print('python'); os.write(1, b'system'); ctypes.CDLL(None).printf(b'buffered by C')"
    process = outside(work, "plan", "tea", "--json")
    out, err = process.communicate(timeout=30)
    assert process.returncode == 0, err
    assert list(json.loads(out)) == list(SUMMARY_KEYS)
    if os.name == "posix":
        assert all(word in err for word in ("python", "system", "buffered by C"))


@pytest.mark.parametrize("as_json", [True, False])
def test_no_solution_exits_3_and_writes_nothing(stand_in: StandIn, folder: Path, as_json: bool) -> None:
    stand_in.planning = raising(NoSolutionError("slosh height of c1\n stands in the way"))
    result = nospill("plan", "tea.toml", "-o", "deep/tea", *(["--json"] if as_json else []))
    assert result.exit_code == 3
    assert result.stderr.splitlines()[-1] == "tea.toml: slosh height of c1 stands in the way"
    assert list(folder.iterdir()) == []
    if as_json:
        summary = json.loads(result.stdout)
        assert tuple(summary) == SUMMARY_KEYS
        told = {key: value for key, value in summary.items() if value is not None}
        assert told == {"scenario": "tea", "status": "failed", "message": "slosh height of c1 stands in the way"}
    else:
        assert result.stdout == ""


@pytest.mark.parametrize("as_json", [True, False])
def test_bad_input_is_one_line_as_written(stand_in: StandIn, monkeypatch: pytest.MonkeyPatch, as_json: bool) -> None:
    message = 'tea.toml: [[cargo]] "c1": radius is "-35 mm"; [bold]give[/bold] a length above 0'

    def fail(_: str) -> None:
        raise ScenarioError(message)

    monkeypatch.setattr(sys.modules["nospill.scenario"], "read_scenario", fail)
    result = nospill("plan", "tea.toml", *(["--json"] if as_json else []))
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", message + "\n")


def test_foreign_folder_is_refused_before_the_work(stand_in: StandIn, folder: Path) -> None:
    (folder / "thesis").mkdir()
    (folder / "thesis" / "a.tex").write_text("dear")
    result = nospill("plan", "tea.toml", "-o", "thesis")
    assert result.exit_code == 2
    assert "did not write" in result.stderr
    assert stand_in.calls == []
    assert (folder / "thesis" / "a.tex").read_text() == "dear"


def test_fault_of_our_own_is_one_line(stand_in: StandIn, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in.planning = raising(ZeroDivisionError("in\nside"))
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 70
    last = result.stderr.splitlines()[-1]
    assert last.startswith("internal error: ZeroDivisionError: in side; please report it")
    assert "Traceback" not in result.stderr
    monkeypatch.setenv("NOSPILL_TRACEBACK", "1")
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 70
    assert "Traceback" in result.stderr
    assert result.stderr.splitlines()[-1] == last


def test_stopped_by_the_user(stand_in: StandIn, folder: Path) -> None:
    stand_in.planning = raising(KeyboardInterrupt())
    result = nospill("plan", "tea.toml", "-o", "tea")
    assert result.exit_code == 130
    assert result.stderr.splitlines()[-1] == "stopped; nothing was written"
    assert list(folder.iterdir()) == []


def test_interrupt_signal_leaves_the_old_plan(outside: Callable[..., subprocess.Popen[str]], folder: Path) -> None:
    (folder / "tea").mkdir()
    (folder / "tea" / "summary.json").write_text("old")
    process = outside("open('started', 'w').close(); time.sleep(60)", "plan", "x", "--json", "-o", "tea")
    deadline = time.monotonic() + 20
    while not (folder / "started").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "stopped; nothing was written"
    assert (folder / "tea" / "summary.json").read_text() == "old"


# --- check and plot -------------------------------------------------------------------------------------------------


@pytest.fixture
def plan_folder(folder: Path) -> Path:
    made = folder / "tea"
    made.mkdir()
    (made / "summary.json").write_text("old")
    return made


@pytest.mark.parametrize("ok", [True, False])
def test_check_judges_again_and_writes_nothing(stand_in: StandIn, plan_folder: Path, ok: bool) -> None:
    stand_in.ok = ok
    stand_in.rows[1] = row("slip", "c2", 0.1 if ok else -0.25, ok=ok)
    result = nospill("check", "tea")
    assert result.exit_code == (0 if ok else 1)
    assert stand_in.calls == ["certify trajectory scene"]
    assert ("certified: all 3 rows" if ok else "not certified: 1 of 3 rows fail") in result.stdout
    told = "Not certified: slip of c2 is 1.25 N against a limit of 1 N (125.00 % of it) at t = 0.500 s.\n"
    assert result.stderr == ("" if ok else told)
    assert os.listdir(plan_folder) == ["summary.json"]


def test_check_and_plot_do_not_load_the_optimiser(stand_in: StandIn, plan_folder: Path) -> None:
    script = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import test_cli\n"
        "modules = test_cli.StandIn().modules(); del modules['nospill.planning.planner']; sys.modules.update(modules)\n"
        "from typer.testing import CliRunner\n"
        "from nospill.cli import app\n"
        "for name in ('check', 'plot'):\n"
        "    assert CliRunner().invoke(app, [name, 'tea']).exit_code == 0, name\n"
        "print([m for m in sys.modules if m.startswith(('nospill.transcription', 'nospill.planning.planner'))])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=30)
    assert done.stdout == "[]\n", done.stderr


def test_plot_replaces_the_figures_whole(stand_in: StandIn, plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "old.pdf").write_text("old")
    result = nospill("plot", "tea")
    assert result.exit_code == 0
    assert result.stdout == "tea/figures/sheet.png\n"
    assert os.listdir(plan_folder / "figures") == ["sheet.png"]
    assert (plan_folder / "summary.json").read_text() == "old"


def test_plot_leaves_foreign_files_alone(stand_in: StandIn, plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "notes.txt").write_text("dear")
    result = nospill("plot", "tea")
    assert result.exit_code == 2
    assert "figures holds files that nospill did not write" in result.stderr
    assert os.listdir(plan_folder / "figures") == ["notes.txt"]


@pytest.mark.parametrize("command", ["check", "plot"])
def test_not_a_plan_folder(stand_in: StandIn, command: str) -> None:
    result = nospill(command, "nowhere")
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", "nowhere is not a plan folder\n")


# --- lists, help, usage ---------------------------------------------------------------------------------------------


def test_version() -> None:
    assert nospill("--version").stdout == f"nospill {version('nospill')}\n"


def test_every_command_is_in_the_list() -> None:
    assert {command.callback.__name__ for command in app.registered_commands if command.callback} == set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command(command: str) -> None:
    result = nospill(command, "--help")
    assert result.exit_code == 0
    assert "Usage: nospill " + command in result.stdout
    assert command in nospill("--help").stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["fly"],
        ["plan"],
        ["plan", "a", "b"],
        ["plan", "a", "--quick"],
        ["plan", "a", "-o"],
        ["check"],
        ["robots", "x"],
        [],
    ],
)
def test_wrong_usage_exits_2_without_traceback(arguments: list[str]) -> None:
    result = nospill(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr


def test_examples_lists_every_example() -> None:
    from nospill.scenario.examples import EXAMPLES

    result = nospill("examples")
    assert result.exit_code == 0
    for name, text in EXAMPLES.items():
        assert name in result.stdout
        assert text in result.stdout


def test_robots() -> None:
    result = nospill("robots", "--json")
    assert result.exit_code == 0
    for entry in json.loads(result.stdout):
        assert entry["name"] in nospill("robots").stdout


def test_schema_is_json() -> None:
    result = nospill("schema")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["properties"]["cargo"]


def test_reader_that_goes_away_is_no_fault(tmp_path: Path) -> None:
    command = "import sys; sys.argv = ['nospill', 'schema']; from nospill.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=30) == 141


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from typer.testing import CliRunner\n"
        "from nospill.cli import app\n"
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0\n"
        "print(sorted({'numpy', 'scipy', 'casadi', 'matplotlib', 'pydantic', 'adam', 'eaik'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=30)
    assert done.stdout == "[]\n", done.stderr
