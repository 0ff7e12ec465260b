"""The process that plans points: reads requests, plans, answers, one line of JSON each.

    python -m nospill.sweeps.planning_process

It ends when its input does. What libraries print goes to the standard error, so that the answers stay whole.
"""

from __future__ import annotations

import base64
import copy
import io
import json
import os
import queue
import sys
import tempfile
import threading
import time
import zipfile
from pathlib import Path
from typing import Any

from nospill import __version__
from nospill.errors import NoSolutionError, NospillError
from nospill.planning.cycles import CyclePlanner
from nospill.planning.planner import Planner
from nospill.planning.varied import finding, planned, varied_from_text
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.sweeps.figures import figures_of, nearest
from nospill.sweeps.points import NO_MOTION, PLANNED, REFUSED, UNCERTIFIED


class PointPlanner:
    """Plans points of one base scenario, from nothing or from the plan of another point."""

    def __init__(self, text: str, name: str) -> None:
        """Of the text of the base scenario, which needs no other file; raises ScenarioError."""
        self._base = varied_from_text(text, name)
        self._head: tuple[str, Planner | CyclePlanner | None] = ("", None)

    def line(self, values: dict[str, Any], *, key: str, warm: dict[str, Any] | None, keep: bool) -> dict[str, Any]:
        """What becomes of a point, as fields of its line.

        Args:
            values: of the point.
            key: of the point.
            warm: key and values of the point to start from; None for none.
            keep: give the plan folder too, packed, as `folder`.
        """
        began = time.perf_counter()
        found: dict[str, Any] = {"warm_from": ""}
        try:
            variant = self._base.changed(values)
            planner = None if warm is None else self._planner_at(warm["key"], warm["values"])
            if planner is None:
                planner = self._base.planner()
                plan = planned(planner, variant)
                self._head = (key, planner)
            else:
                found["warm_from"] = warm["key"] if warm is not None else ""
                plan = planned(copy.copy(planner), variant)  # the copy moves on, the one at the head stays there
            found |= outcome_of(plan)
            if keep:
                found["folder"] = packed(plan)
        except NoSolutionError as error:
            found |= {"ending": NO_MOTION, "reason": one_line(error)}
        except NospillError as error:
            found |= {"ending": REFUSED, "reason": one_line(error)}
        return found | {"plan_s": time.perf_counter() - began, "nospill": __version__}

    def _planner_at(self, key: str, values: dict[str, Any]) -> Planner | CyclePlanner | None:
        """The planner that has just planned a point; None where it has no motion."""
        if self._head[0] != key:
            planner = self._base.planner()
            try:
                planned(planner, self._base.changed(values))
            except NospillError:
                self._head = (key, None)
            else:
                self._head = (key, planner)
        return self._head[1]


def outcome_of(plan: Plan | CyclePlan) -> dict[str, Any]:
    """Fields of a line that a plan answers."""
    ok = plan.certificate.ok
    return {
        "ending": PLANNED if ok else UNCERTIFIED,
        "reason": "" if ok else finding(plan),
        "nearest": nearest(plan),
        "figures": figures_of(plan),
    }


def packed(plan: Plan | CyclePlan) -> str:
    """The plan folder as a ZIP archive in base 64."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "plan"
        plan.save(folder)
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(folder.rglob("*")):
                archive.write(file, file.relative_to(folder))
    return base64.b64encode(content.getvalue()).decode("ascii")


def one_line(error: Exception) -> str:
    """The message of an error on one line."""
    return " ".join(str(error).split())


def main() -> None:
    """Answer requests until there are no more."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    requests: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_read, args=(requests,), daemon=True).start()
    planner: PointPlanner | None = None
    while True:
        request = json.loads(requests.get())
        if "scenario" in request:
            planner = PointPlanner(request["scenario"], request["name"])
            continue
        assert planner is not None  # the scenario comes first
        answers.write(json.dumps(planner.line(**request)) + "\n")
        answers.flush()


def _read(requests: queue.Queue[str]) -> None:
    """Hand requests on; whoever sends them may die, and then nobody waits for an answer."""
    for line in sys.stdin:
        requests.put(line)
    os._exit(0)


if __name__ == "__main__":
    main()
