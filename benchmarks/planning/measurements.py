"""What the benchmark measures, in the order in which a round goes through it: the whole physics first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from benchmarks.planning.scenes import UNSEEN

WHOLE_EXAMPLES = (
    "matrix-liquid",
    "matrix-liquid-tilt",
    "mixed-tray",
    "soup-and-wine",
    "coffee-to-go",
    "vial-rack",
    "shelf-to-table",
)
"""Planned with the whole physics."""
EXAMPLES = ("matrix-liquid", "matrix-rigid", "matrix-liquid-tilt")
"""Planned with the published physics."""
CUPS = (4, 32)
DIFFERENT = (4, 64)
WELLS = (132, 500)
INTERVALS = (100, 400)
GROUPS = (
    "whole",
    "whole-warm",
    "process",
    "baseline",
    "baseline-rigid",
    "cold",
    "virtual",
    "warm",
    "first",
    "cups",
    "different",
    "wells",
    "grid",
    "toppra",
)


@dataclass(frozen=True)
class Measurement:
    """Something measured once a round.

    Attributes:
        key: name in the JSON file. group: one of `GROUPS`. run: measures and returns figures, `seconds` among them.
        once: long enough to be measured in the first round only when in a hurry.
    """

    key: str
    group: str
    run: Callable[[], dict[str, Any]]
    once: bool = False


class Processes(Protocol):
    """What measures in processes of their own."""

    def task(self, *arguments: str, mode: str = "background") -> dict[str, Any]:
        """Figures of one of the `tasks`, in a mode of NOSPILL_COMPILE."""
        ...

    def whole_process(self, *, cold_cache: bool, figures: bool = False) -> dict[str, Any]:
        """Figures of a command from start to exit."""
        ...

    def python(self, statement: str) -> dict[str, Any]:
        """Figures of an interpreter that runs a statement."""
        ...

    def first_plan(self, name: str, *, empty: bool) -> dict[str, Any]:
        """Figures of the first plan of a structure."""
        ...


def measurements(bench: Processes) -> list[Measurement]:
    """Everything, in the order in which a round goes through it."""
    return [*_whole(bench), *_published(bench), *_first_plans(bench), *_larger(bench)]


def _whole(bench: Processes) -> list[Measurement]:
    """Examples with the whole physics, and the command."""
    found = []
    for name in WHOLE_EXAMPLES:
        found.append(Measurement(f"cold {name}", "whole", lambda name=name: bench.task("whole", name)))
        found.append(Measurement(f"warm {name}", "whole-warm", lambda name=name: bench.task("whole-warm", name)))
    return [
        *found,
        Measurement("process, second run", "process", lambda: bench.whole_process(cold_cache=False)),
        Measurement(
            "process with figures, second run", "process", lambda: bench.whole_process(cold_cache=False, figures=True)
        ),
        Measurement("process, cold cache", "process", lambda: bench.whole_process(cold_cache=True), once=True),
        Measurement("imports of a plan", "process", lambda: bench.python("import nospill.planning.planner")),
    ]


def _published(bench: Processes) -> list[Measurement]:
    """The published transcription, and examples with the published physics."""
    task = bench.task
    found = [
        Measurement("baseline liquid", "baseline", lambda: task("baseline", "liquid"), once=True),
        Measurement("baseline rigid", "baseline-rigid", lambda: task("baseline", "rigid")),
        Measurement("toppra, rigid on a level tray", "toppra", lambda: task("toppra", "matrix-rigid")),
    ]
    for name in EXAMPLES:
        found.append(Measurement(f"one mode: cold {name}", "cold", lambda name=name: task("cold", name)))
    for name in ("matrix-liquid", "matrix-rigid"):
        run = lambda name=name: task("cold", name, mode="off")  # noqa: E731
        found.append(Measurement(f"one mode: no compiler {name}", "virtual", run))
    for name in ("matrix-liquid", "matrix-liquid-tilt"):
        found.append(Measurement(f"one mode: warm {name}", "warm", lambda name=name: task("warm", name)))
    return found


def _first_plans(bench: Processes) -> list[Measurement]:
    """Structures that no example has, with compiled blocks and with an empty cache."""
    found = []
    for name in UNSEEN:
        for empty in (False, True):
            key = f"first plan, {name}, {'empty cache' if empty else 'blocks compiled'}"
            run = lambda name=name, empty=empty: bench.first_plan(name, empty=empty)  # noqa: E731
            found.append(Measurement(key, "first", run, once=empty))
    return found


def _larger(bench: Processes) -> list[Measurement]:
    """More objects and finer grids, with the published physics."""
    task, found = bench.task, []
    # On the virtual machine: compiling each of these trays first would take longer than the measurement.
    for count in CUPS:
        run = lambda count=count: task("cups", str(count), mode="off")  # noqa: E731
        found.append(Measurement(f"{count} cups", "cups", run, once=count > 8))
    for count in DIFFERENT:
        run = lambda count=count: task("different", str(count), mode="off")  # noqa: E731
        found.append(Measurement(f"{count} different cups", "different", run, once=count > 16))
    for count in WELLS:
        run = lambda count=count: task("wells", str(count))  # noqa: E731
        found.append(Measurement(f"{count} wells and vials", "wells", run, once=True))
    for intervals in INTERVALS:
        run = lambda intervals=intervals: task("cold", "matrix-liquid", "--intervals", str(intervals))  # noqa: E731
        found.append(Measurement(f"N = {intervals}", "grid", run))
    return found
