"""What the campaign says: rates, times, reasons, worst cases and the spread between starts, as a page's section."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.campaign.distributions import DISTRIBUTIONS, FIRST_COMBINED, FIRST_WITH_VESSELS
from benchmarks.campaign.pairs import pair_table
from nospill.laws.constraints import CONSTRAINTS

BEGIN, END = "<!-- campaign: begin -->", "<!-- campaign: end -->"
VESSELS_BEGIN, VESSELS_END = "<!-- vessels: begin -->", "<!-- vessels: end -->"
COMBINED_BEGIN, COMBINED_END = "<!-- combined: begin -->", "<!-- combined: end -->"
DRAWN_BEGIN, DRAWN_END = "<!-- distributions: begin -->", "<!-- distributions: end -->"

WORST = 10
_NEAR = 1.01
_LONGEST_REASON = 160
_ORDER = (
    "planned",
    "not certified",
    "proven impossible",
    "out of reach",
    "refused",
    "not found",
    "out of time",
    "crash",
)

Line = dict[str, Any]


def write_page(lines: list[Line], page: Path) -> None:
    """Put the tables and the distributions between the page's markers; a table for each kind of seeds."""
    text = page.read_text(encoding="utf-8")
    combined = [line for line in lines if line["seed"] >= FIRST_COMBINED]
    vessels = [line for line in lines if FIRST_WITH_VESSELS <= line["seed"] < FIRST_COMBINED]
    others = [line for line in lines if line["seed"] < FIRST_WITH_VESSELS]
    if combined:
        text = _between(text, COMBINED_BEGIN, COMBINED_END, "\n".join([*section(combined), "", *pair_table(combined)]))
    if vessels:
        text = _between(text, VESSELS_BEGIN, VESSELS_END, "\n".join(section(vessels)))
    if others or not lines:
        text = _between(text, BEGIN, END, "\n".join(section(others)))
    drawn = ["| drawn | from |", "|---|---|", *(f"| {name} | {shown} |" for name, shown in DISTRIBUTIONS.rows())]
    page.write_text(_between(text, DRAWN_BEGIN, DRAWN_END, "\n".join(drawn)), encoding="utf-8")


def _between(text: str, begin: str, end: str, content: str) -> str:
    before, rest = text.split(begin)
    _, after = rest.split(end)
    return f"{before}{begin}\n{content}\n{end}{after}"


def section(lines: list[Line]) -> Iterator[str]:
    """Lines of Markdown for all that is in a file."""
    cases = list({line["seed"]: line for line in lines if "starts_from" not in line}.values())
    starts = {line["seed"]: line for line in lines if "starts_from" in line}
    if not cases:
        yield "No case has been run yet."
        return
    commits = ", ".join(dict.fromkeys(line.get("commit") or "unknown" for line in cases))
    compiled = {line.get("compiled", False) for line in cases}
    how = "functions compiled in part" if len(compiled) > 1 else "compiled functions" if True in compiled else ""
    yield f"{len(cases)} scenarios, commit {commits}; one thread, {how or 'no compiled functions'}, processor time."
    yield ""
    yield from _rates(cases)
    yield ""
    yield from _times(cases)
    yield ""
    yield from _reasons(cases)
    yield ""
    yield from _worst(cases)
    if starts:
        yield ""
        known = {line["seed"]: line for line in cases}
        yield from spread(known, {seed: line for seed, line in starts.items() if seed in known})


def false_certificate(line: Line) -> bool:
    """Whether a plan called certified is rejected by the finer certificate or by the simulation, or its row jumps."""
    alone = line["kind"] == "planned" and not (line["fine"]["ok"] and line["verify"]["ok"])
    later = following(line).values()
    return alone or any(bool(after.get("seam")) or ("fine" in after and false_certificate(after)) for after in later)


def following(line: Line) -> dict[str, Line]:
    """The motions that were planned from the state in which another one ends, or is, by what they are called."""
    return {name: line[key] for key, name in _FOLLOWING.items() if line.get(key)}


_FOLLOWING = {"next": "next motions in a row", "from_the_midst": "motions from the midst of a plan"}


def has_reason(line: Line) -> bool:
    """Whether a case without a certified plan says what is in the way.

    That is a constraint by its name, or else what its ending stands for: reach and limits of the arm, a fault of the
    scenario, the row to which the judge objects.
    """
    reason = line.get("reason") or ""
    if line["kind"] in ("out of reach", "refused", "not certified"):
        return bool(reason)
    if (line.get("blamed") or "planning").startswith("planning"):  # nothing but the search is to blame
        return line["kind"] not in ("crash", "out of time") and any(item.name in reason for item in CONSTRAINTS)
    return True


def _rates(cases: list[Line]) -> Iterator[str]:
    counts = Counter(line["kind"] for line in cases)
    planned = [line for line in cases if line["kind"] == "planned"]
    yield "| | cases | share |"
    yield "|---|---:|---:|"
    for kind in (*_ORDER, *sorted(set(counts) - set(_ORDER))):
        yield f"| {kind} | {counts[kind]} | {counts[kind] / len(cases):.1%} |"
    fine = sum(not line["fine"]["ok"] for line in planned)
    moved = sum(not line["verify"]["ok"] for line in planned)
    open_cases = [line for line in cases if line["kind"] != "planned"]
    silent = sum(not has_reason(line) for line in open_cases)
    yield f"| certified, rejected by the certificate at 8 kHz | {fine} | |"
    yield f"| certified, something moves in MuJoCo | {moved} | |"
    for name in _FOLLOWING.values():
        rows = [following(line)[name] for line in planned if name in following(line)]
        if rows:
            yield f"| {name}, certified | {sum(row['kind'] == 'planned' for row in rows)} of {len(rows)} | |"
            yield f"| of these false, or with a jump of the arm | {sum(map(false_certificate, rows))} | |"
    yield f"| failures that do not name what is in the way | {silent} of {len(open_cases)} | |"
    meant = [line for line in cases if line.get("unreachable")]
    shown = sum(line["kind"] == "out of reach" for line in meant)
    yield f"| left out of reach on purpose and reported so | {shown} of {len(meant)} | |"


def _times(cases: list[Line]) -> Iterator[str]:
    yield "| | number | median | 90 % | greatest |"
    yield "|---|---:|---:|---:|---:|"
    planned = [line for line in cases if line["kind"] == "planned"]
    unsolved = [line for line in cases if line["kind"] in ("not certified", "not found", "proven impossible")]
    tilting = [line for line in planned if "tilt to" in line["structure"]]
    level = [line for line in planned if "tilt to" not in line["structure"]]
    for shown, chosen, key in (
        ("planning, s of processor time", planned, "plan_processor_s"),
        ("of these level, s", level, "plan_processor_s"),
        ("of these tilting, s", tilting, "plan_processor_s"),
        ("until no motion was found, s", unsolved, "plan_processor_s"),
        ("duration of the motion, s", planned, "duration_s"),
        ("iterations", planned, "iterations"),
        ("rounds of tightening", planned, "rounds"),
        ("peak memory, MB", planned, "peak_memory_mb"),
    ):
        values = sorted(line[key] for line in chosen if line.get(key) is not None)
        if values:
            ninety = values[min(len(values) - 1, int(0.9 * len(values)))]
            yield f"| {shown} | {len(values)} | {statistics.median(values):.3g} | {ninety:.3g} | {values[-1]:.3g} |"


def _reasons(cases: list[Line]) -> Iterator[str]:
    yield "| ending | reason, figures left out | cases | a seed |"
    yield "|---|---|---:|---:|"
    groups: dict[tuple[str, str], list[int]] = {}
    for line in cases:
        if line["kind"] != "planned":
            groups.setdefault((line["kind"], pattern(line.get("reason") or "no reason")), []).append(line["seed"])
    for (kind, shown), seeds in sorted(groups.items(), key=lambda item: -len(item[1])):
        yield f"| {kind} | {shown} | {len(seeds)} | {seeds[0]} |"
    binding = Counter((line["binding"] or "").split(" of ")[0] for line in cases if line["kind"] == "planned")
    if binding:
        yield ""
        most = ", ".join(f"{name} {count}" for name, count in binding.most_common())
        yield f"What certified motions use most of: {most}."


def pattern(reason: str) -> str:
    """A reason without its figures and names, so that like ones are counted together; fit for a cell of a table."""
    text = reason.split("; ")[0].removeprefix("No motion found: ")
    text = re.sub(r"'[^']*'|\"[^\"]*\"", "..", text)
    text = re.sub(r" of (c\d+|\S*joint\S*|[AJa-z_]+\d)\b", " of ..", text)
    text = re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "#", text)
    return text.replace("|", "/").replace("\n", " ")[:_LONGEST_REASON]


def _worst(cases: list[Line]) -> Iterator[str]:
    yield "| worst ten: seed | scenario | ending | why it is here |"
    yield "|---:|---|---|---|"
    for line in sorted(cases, key=_badness, reverse=True)[:WORST]:
        shown = _complaint(line).replace("|", "/").replace("\n", " ")[: 2 * _LONGEST_REASON]
        yield f"| {line['seed']} | {line.get('structure', 'not known')} | {line['kind']} | {shown} |"


def _badness(line: Line) -> tuple[int, float]:
    """What counts more: a wrong certificate, then a crash, then no answer, then a long time."""
    rank = {"crash": 4, "out of time": 3, "not certified": 2, "not found": 1}.get(line["kind"], 0)
    return 5 if false_certificate(line) else rank, float(line.get("plan_processor_s") or 0.0)


def _complaint(line: Line) -> str:
    for name, after in following(line).items():
        if false_certificate(after):
            return f"of {name}: {after.get('seam') or _complaint(after)}"
    if false_certificate(line):
        fine = "" if line["fine"]["ok"] else "8 kHz: " + "; ".join(line["fine"]["broken"])
        moved = "" if line["verify"]["ok"] else "MuJoCo: " + line["verify"]["message"]
        return "; ".join(filter(None, (fine, moved)))
    return line.get("reason") or f"planned in {line.get('plan_processor_s', 0.0):.1f} s of processor time"


def spread(cases: dict[int, Line], starts: dict[int, Line]) -> Iterator[str]:
    """How plain planning does against further random starts of the same scenarios."""
    solved_by_any = solved = near = 0
    ratios: list[float] = []
    scatter: list[float] = []
    for seed, line in starts.items():
        own = cases[seed].get("duration_s") if cases[seed]["kind"] == "planned" else None
        others = [outcome["duration_s"] for outcome in line["starts_from"] if outcome.get("duration_s")]
        known = others + ([own] if own is not None else [])
        if not known:
            continue
        solved_by_any += 1
        best = min(known)
        if len(others) > 1:
            scatter.append(max(others) / min(others) - 1.0)
        if own is None:
            continue
        solved += 1
        near += own <= _NEAR * best
        ratios.append(own / best - 1.0)
    tried = sum(len(line["starts_from"]) for line in starts.values())
    short = sum(len(line["starts_from"]) < line["asked"] for line in starts.values())
    ended = sum(bool(outcome.get("duration_s")) for line in starts.values() for outcome in line["starts_from"])
    yield f"| {len(starts)} cases against further random starts | |"
    yield "|---|---:|"
    yield f"| solved by any start | {solved_by_any} |"
    yield f"| of these by plain `plan` | {_share(solved, solved_by_any)} |"
    yield f"| of these within 1 % of the best duration | {_share(near, solved)} |"
    yield f"| single random starts that end in a certified motion | {_share(ended, tried)} |"
    if short:
        yield f"| cases whose starts were cut off by the time limit | {short} |"
    yield f"| plain `plan` above the best: median, 90 %, greatest | {_three(ratios)} |"
    yield f"| slowest over fastest random start of a case: median, 90 %, greatest | {_three(scatter)} |"


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({part / whole:.1%})" if whole else "none"


def _three(values: Iterable[float]) -> str:
    ordered = sorted(values)
    if not ordered:
        return "none"
    chosen = (statistics.median(ordered), ordered[min(len(ordered) - 1, int(0.9 * len(ordered)))], ordered[-1])
    return ", ".join(f"{value:.2%}" for value in chosen)
