"""Random scenarios of the campaign with the full physics, planned, and their liquids followed by the nonlinear flow.

    python -m benchmarks.water.random_plans FIRST LAST -o lines.jsonl [--seconds 60]

A line for each certified plan with a liquid that the flow is known of; `python -m benchmarks.water.random_plans --table
lines.jsonl` prints the excess of crests and of what is left after the end, by the height of the limit over the radius.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.campaign.scenes import draw_case
from nospill.errors import NospillError
from nospill.planning.planner import plan
from nospill.scenario import scene_from_table
from nospill.scene.heights import unsupported
from nospill.verify import verify_water

EDGES = (0.0, 0.1, 0.2, 0.3, 0.45, 1.0)
"""Of the limit over the radius or half side."""


def followed(seed: int, seconds: float) -> dict[str, Any] | None:
    """Plan a seed's scenario and follow its liquids; None where there is no certified plan with such a liquid."""
    try:
        drawn = draw_case(seed).table
        drawn["planning"].pop("slosh_modes")  # the campaign's one mode saves time; the certificate is to see them all
        scene = scene_from_table(drawn, name=str(seed))
        if not any(item.filling and unsupported(item) is None for item in scene.cargo):
            return None
        found = plan(scene.changed({"fidelity": "full", "planning.max_plan_time": seconds}))
    except NospillError:
        return None
    if not found.certificate.ok:
        return None
    report = verify_water(found).to_dict()
    for item in report["liquids"]:
        cargo = next(own for own in found.scene.cargo if own.name == item["name"])
        assert cargo.filling is not None
        half = float(np.min(cargo.container.section(cargo.filling.liquid_height).half_lengths))
        item["limit_over_radius"] = cargo.filling.max_slosh_height / half
        item["certified_over_radius"] = item["certified_mm"] / 1e3 / half
    return {"seed": seed, "tilts": bool(found.maxima.tilt > 1e-3), **report}


def table(lines: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Excess of crests and of what is left after the end, of flows that are trusted, per cent."""
    yield "| certified crest over radius | liquids, trusted | second order over certified | full over certified |"
    yield "|---|---|---|---|"
    cups = [item for line in lines for item in line["liquids"]]
    for low, high in pairwise(EDGES):
        own = [item for item in cups if low <= item["certified_over_radius"] < high]
        sure = [item for item in own if item["doubt"] is None]
        figures = [_spread([item[f"{name}_mm"] / item["certified_mm"] for item in sure]) for name in ("second", "full")]
        yield f"| {low:g} to {high:g} | {len(own)}, {len(sure)} | " + " | ".join(figures) + " |"


def _spread(values: Sequence[float]) -> str:
    if not values:
        return "-"
    low, middle, high = 1e2 * (np.percentile(values, [0, 50, 100]) - 1)
    return f"{low:+.0f} to {high:+.0f} %, median {middle:+.0f} %"


def main() -> None:
    """Plan seeds, or print the table of those that are planned."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("seeds", nargs="*", type=int)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--table", type=Path)
    given = parser.parse_args()
    if given.table:
        print(*table([json.loads(line) for line in given.table.read_text("utf-8").splitlines()]), sep="\n")
        return
    first, last = given.seeds
    for seed in range(first, last):
        found = followed(seed, given.seconds)
        if found is not None:
            with given.output.open("a", encoding="utf-8") as file:
                file.write(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
