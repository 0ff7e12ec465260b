"""What the benchmark says, as the tables of its page."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.campaign.report import pattern
from benchmarks.carry.families import FAMILIES

BEGIN, END = "<!-- carry: begin -->", "<!-- carry: end -->"

Line = dict[str, Any]


def write_page(lines: list[Line], page: Path) -> None:
    """Put the tables between the page's markers."""
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    content = "\n".join(section(list({line["seed"]: line for line in lines}.values())))
    page.write_text(f"{before}{BEGIN}\n{content}\n{END}{after}", encoding="utf-8")


def section(lines: list[Line]) -> Iterator[str]:
    """Lines of Markdown for all that was run."""
    if not lines:
        yield "No problem has been run yet."
        return
    commits = ", ".join(dict.fromkeys(line.get("commit") or "unknown" for line in lines))
    yield f"{len(lines)} problems, commit {commits}; times by the clock."
    yield ""
    yield from _by_group("family", {name: [line for line in lines if line["family"] == name] for name in FAMILIES})
    yield ""
    groups: dict[str, list[Line]] = {}
    for line in lines:
        words = line["structure"].split(", ")
        for word in (words[0], words[-1]):
            groups.setdefault(word, []).append(line)
        known = "known motion passes a singularity" if line["singular"] else "known motion keeps the branch"
        groups.setdefault(known, []).append(line)
    yield from _by_group("arm, tray, known motion", dict(sorted(groups.items())))
    yield ""
    yield from _checks(lines)
    yield ""
    yield from _figures(lines)
    yield ""
    yield from _failures(lines)


def _by_group(title: str, groups: dict[str, list[Line]]) -> Iterator[str]:
    yield f"| {title} | problems | planned | share | planning, median s | duration over that on the way, median |"
    yield "|---|---:|---:|---:|---:|---:|"
    for name, lines in {**groups, "all": list({id(i): i for own in groups.values() for i in own}.values())}.items():
        planned = [line for line in lines if line["kind"] == "planned"]
        if not lines:
            continue
        times = _median([line["plan_s"] for line in planned], ".1f")
        ratio = _median([line["duration_s"] / line["on_way_s"] for line in planned if line.get("on_way_s")], ".2f")
        yield f"| {name} | {len(lines)} | {len(planned)} | {len(planned) / len(lines):.0%} | {times} | {ratio} |"


def _checks(lines: list[Line]) -> Iterator[str]:
    planned = [line for line in lines if line["kind"] == "planned"]
    yield "| of the certified motions | |"
    yield "|---|---:|"
    yield f"| with a collision that coal sees at 20 kHz | {sum(line['touching'] > 0 for line in planned)} |"
    yield f"| in which something touches or moves in MuJoCo | {sum(not line['verify']['ok'] for line in planned)} |"
    on_way = [line for line in planned if line.get("on_way_s")]
    yield f"| of which the way, too, is certified as a given path | {len(on_way)} of {len(planned)} |"
    yield f"| cells drawn without a clear start and goal | {sum(line['blocked'] for line in lines)} |"
    yield f"| problems drawn without a motion, and drawn anew | {sum(line['pathless'] for line in lines)} |"


def _figures(lines: list[Line]) -> Iterator[str]:
    planned = [line for line in lines if line["kind"] == "planned"]
    yield "| | number | median | 95 % | greatest |"
    yield "|---|---:|---:|---:|---:|"
    for shown, values in (
        ("planning, s", [line["plan_s"] for line in planned]),
        ("planning, s of processor time", [line["plan_processor_s"] for line in planned]),
        (
            "until none was found, s",
            [line["plan_s"] for line in lines if line not in planned and "plan_s" in line],
        ),
        ("duration, s", [line["duration_s"] for line in planned]),
        ("duration over that on the way", [i["duration_s"] / i["on_way_s"] for i in planned if i.get("on_way_s")]),
        ("the slow motion over it", [line["slow_s"] / line["duration_s"] for line in planned]),
    ):
        if values:
            ordered = sorted(values)
            most = ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]
            yield f"| {shown} | {len(values)} | {statistics.median(values):.3g} | {most:.3g} | {ordered[-1]:.3g} |"


def _failures(lines: list[Line]) -> Iterator[str]:
    groups: dict[tuple[str, str], list[Line]] = {}
    for line in lines:
        if line["kind"] != "planned":
            groups.setdefault((line["kind"], pattern(line.get("reason") or "no reason")), []).append(line)
    if not groups:
        return
    yield "| ending | reason, figures left out | cases | families | a seed |"
    yield "|---|---|---:|---|---:|"
    for (kind, shown), found in sorted(groups.items(), key=lambda item: -len(item[1])):
        families = ", ".join(f"{name} {count}" for name, count in Counter(i["family"] for i in found).most_common())
        yield f"| {kind} | {shown} | {len(found)} | {families} | {found[0]['seed']} |"


def _median(values: list[float], shown: str) -> str:
    return format(statistics.median(values), shown) if values else "-"
