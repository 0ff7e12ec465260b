"""Random scenarios of the campaign with the full physics, planned, and their liquids followed by the whole flow.

    python -m benchmarks.water.random_plans -o lines.jsonl [--cases 100] [--seconds 60] [--residual default]
        [--height default] [--keep DIR]
    python -m benchmarks.water.random_plans --table FILE [--residual default] [--height default]

Seeds are those of the campaign's first cases that it planned with an upright cup or box of liquid, here with all modes
in place of one. A line for each, also where there is no certified plan, is written at once and whole; seeds that are in
the file are not planned again, and those without a plan there not to the other order of residual heights either. The
table has crests and what is left after the end over their limits, of the flows that are trusted, by the height of the
limit over the radius or half side.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.campaign.scenes import draw_case
from nospill.errors import NospillError
from nospill.planning.planner import plan
from nospill.scenario import scene_from_table
from nospill.scene.heights import linear_since
from nospill.scene.scene import Scene
from nospill.sweeps.lines import lines_file, read_lines
from nospill.verify import verify_water

CASES = Path(__file__).parents[1] / "results" / "campaign.jsonl.gz"
_SECOND = "second order"
_LEFT_OUT = "default"
"""Order of heights that the scenario does not state."""
EDGES = (0.0, 0.1, 0.2, 0.3, 0.45, 1.5)
"""Of the limit over the radius or half side."""
ALLOWED = {"crest": ((0.3, 1.03), (0.45, 1.08)), "left": ((0.3, 1.1),)}
"""Largest ratio to the limit that is asked for up to a limit over the radius."""


def scene_of(seed: int, residual: str, seconds: float, height: str = _LEFT_OUT) -> Scene | None:
    """A seed's scenario with the full physics; None where no liquid of it is judged to that order."""
    drawn = draw_case(seed).table
    drawn["planning"].pop("slosh_modes", None)  # the campaign's one mode saves time; the certificate is to see them all
    scene = scene_from_table(drawn, name=str(seed))
    if not any(item.filling and linear_since(item) is None for item in scene.cargo):
        return None
    wanted: dict[str, Any] = {"fidelity": "full", "planning.max_plan_time": seconds}
    if residual != _LEFT_OUT:
        wanted["motion.residual_height"] = residual
    if height != _LEFT_OUT and not (height == _SECOND and residual in ("linear", _SECOND)):  # what it is anyway
        if any(linear_since(item) for item in scene.cargo):  # a stated order is refused where one liquid has none
            return None
        wanted["motion.slosh_height"] = height
    return scene.changed(wanted)


def followed(seed: int, scene: Scene, orders: Mapping[str, str], keep: Path | None = None) -> dict[str, Any]:
    """The line of a seed: its plan's figures and its liquids, or why there is none."""
    begun = time.process_time()
    line: dict[str, Any] = {"seed": seed, **orders}
    try:
        found = plan(scene)
        line |= {"plan_cpu_s": time.process_time() - begun, "duration_s": found.duration, "ok": found.certificate.ok}
        if not found.certificate.ok:
            return {**line, "reason": found.message}
        if keep is not None:
            found.save(keep / f"{seed}-{'-'.join(orders.values()).replace(' ', '-')}")
        report = verify_water(found)
    except NospillError as error:
        return {**line, "ok": False, "reason": str(error)}
    liquids = []
    for item in report.to_dict()["liquids"]:
        cargo = next(own for own in found.scene.cargo if own.name == item["name"])
        assert cargo.filling is not None
        half = float(np.min(cargo.container.section(cargo.filling.liquid_height).half_lengths))
        order = "linear" if linear_since(cargo) else _SECOND
        liquids.append({**item, "order": order, "limit_over_radius": cargo.filling.max_slosh_height / half})
    return {**line, "tilts": bool(found.maxima.tilt > 1e-3), "liquids": liquids}


def table(lines: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Crests and what is left after the end over their limits, of flows that are trusted."""
    yield "| limit over radius | liquids, trusted | crest over its limit | after the end over its limit |"
    yield "|---|---|---|---|"
    cups = [item for line in lines for item in line.get("liquids", ()) if item["order"] == _SECOND]
    for low, high in pairwise(EDGES):
        own = [item for item in cups if low <= item["limit_over_radius"] < high]
        sure = [item for item in own if item["doubt"] is None]
        crests = _spread([item["full_mm"] / item["limit_mm"] for item in sure], _allowed("crest", high))
        ended = [item for item in sure if item["residual_limit_mm"]]
        left = _spread([item["residual_full_mm"] / item["residual_limit_mm"] for item in ended], _allowed("left", high))
        yield f"| {low:g} to {high:g} | {len(own)}, {len(sure)} | {crests} | {left} |"


def _orders(line: Mapping[str, Any]) -> dict[str, str]:
    return {"residual": line["residual"], "height": line.get("height", _SECOND)}


def _allowed(which: str, high: float) -> float | None:
    return next((ratio for edge, ratio in ALLOWED[which] if high <= edge), None)


def _spread(ratios: Sequence[float], allowed: float | None) -> str:
    if not ratios:
        return "-"
    low, middle, high = 1e2 * (np.percentile(ratios, [0, 50, 100]) - 1)
    words = f"{low:+.0f} to {high:+.0f} %, median {middle:+.0f} %"
    return words if allowed is None else f"{words}; {np.mean(np.array(ratios) <= allowed):.0%} keep {allowed:.2f}"


def main() -> None:
    """Plan seeds until enough are certified, or print the table of those that are planned."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--residual", choices=(_LEFT_OUT, "linear", _SECOND, "nonlinear"), default=_LEFT_OUT)
    parser.add_argument("--height", choices=(_LEFT_OUT, _SECOND, "nonlinear"), default=_LEFT_OUT)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--table", type=Path)
    given = parser.parse_args()
    orders = {"residual": given.residual, "height": given.height}
    if given.table:
        print(*table([line for line in read_lines(given.table) if _orders(line) == orders]), sep="\n")
        return
    with lines_file(given.output) as file:
        known = {line["seed"]: line for line in file.known if _orders(line) == orders}
        certified = sum(line["ok"] for line in known.values())
        without = {line["seed"] for line in file.known if not line["ok"]}
        for case in read_lines(CASES):
            if certified >= given.cases:
                return
            if case["kind"] != "planned" or case["seed"] in known.keys() | without:
                continue
            scene = scene_of(case["seed"], given.residual, given.seconds, given.height)
            if scene is None:
                continue
            line = followed(case["seed"], scene, orders, given.keep)
            file.append(line)
            certified += line["ok"]


if __name__ == "__main__":
    main()
