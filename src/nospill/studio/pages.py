"""What the studio writes in the browser: progress, verdict, certificate, faults, as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from nospill.core.short_names import short_names
from nospill.film.colours import use_colours
from nospill.judge.verdict import Row
from nospill.judge.wording import integrity_line, row_text
from nospill.plans.plan import Plan
from nospill.studio.checks import Fault
from nospill.studio.planning import PlanningState

_TEXT = "padding:2px 10px;font-size:13px;line-height:1.4;color:#222"
_WRONG = "#9A4300"
_MOST_FAULTS = 8
_COLUMNS = (("constraint", "left"), ("of", "left"), ("use of limit", "right"), ("value", "right"), ("limit", "right"))
_PHASES = {
    "start": "starting",
    "kinematics": "joint paths",
    "build": "building the problem",
    "solve": "solving",
    "export": "writing the samples",
    "certify": "judging",
}


def fault_note(sentences: Sequence[str]) -> str:
    """The faults of one field, to stand below it; empty without any."""
    if not sentences:
        return ""
    lines = "<br>".join(escape(sentence) for sentence in sentences)
    return (
        f"<div class='nospill-fault' role='alert' style='margin:-2px 10px 8px 10px;padding:2px 6px;border-left:3px "
        f"solid {_WRONG};background:#fdf1e7;color:{_WRONG};font-size:12px;line-height:1.35;"
        f"overflow-wrap:anywhere'>{lines}</div>"
    )


def fault_list(faults: Sequence[Fault]) -> str:
    """Every fault with its place, above the button that they disable."""
    if not faults:
        return ""
    lines = [f"<li>{escape(fault.sentence)}</li>" for fault in faults[:_MOST_FAULTS]]
    more = f"<li>and {len(faults) - _MOST_FAULTS} more</li>" if len(faults) > _MOST_FAULTS else ""
    count = "1 value" if len(faults) == 1 else f"{len(faults)} values"
    return (
        f"<div id='nospill-faults' style='{_TEXT};color:{_WRONG};overflow-wrap:anywhere'><b>{count} to correct before "
        f"planning</b><ul style='margin:2px 0 0 0;padding-left:18px'>{''.join(lines)}{more}</ul></div>"
    )


def progress_note(state: PlanningState) -> str:
    """Where planning stands."""
    if state.stage == "waiting":
        words = "waiting for another plan to end"
    elif state.stage == "stopping":
        words = "stopping"
    elif state.stage == "planning":
        words = _PHASES.get(state.phase, state.phase)
    else:
        words = ""
    if not words:
        look = f";color:{_WRONG}" if state.stage == "failed" else ""
        return (
            f"<div id='nospill-progress' style='{_TEXT}{look}'>{escape(state.message)}</div>" if state.message else ""
        )
    figures = [
        f"iteration {state.iteration}" if state.iteration is not None else "",
        f"duration {state.duration_s:.3f} s" if state.duration_s is not None else "",
        f"violation {state.violation:.1e}" if state.violation is not None else "",
    ]
    details = " · ".join(filter(None, figures)) or "&nbsp;"
    return (
        f"<div id='nospill-progress' style='{_TEXT}'><b>{escape(words)}</b> "
        f"<span style='color:#555'>{state.seconds:.1f} s</span><br>"
        f"<span style='font-variant-numeric:tabular-nums'>{details}</span></div>"
    )


def verdict(plan: Plan, *, before: float | None, stale: bool) -> str:
    """Duration and verdict in large letters.

    Args:
        plan: what was planned.
        before: duration of the plan before it, s.
        stale: whether the scenario was changed since.
    """
    good = plan.certificate.ok
    change = ""
    if before is not None:
        change = f" <span style='font-size:13px;color:#555'>({plan.duration - before:+.3f} s)</span>"
    badge = (
        f"<span id='nospill-status' style='font-size:13px;font-weight:600;padding:2px 8px;border-radius:9px;color:#fff;"
        f"background:{'#00684D' if good else '#A63C00'}'>{plan.certificate.word}</span>"
    )
    note = "<div style='color:#9A4300'>The scenario was changed since.</div>" if stale else ""
    report = plan.report
    effort = f"planned in {report.plan_time:.2f} s, {report.iterations} iterations"
    return (
        f"<div id='nospill-verdict' data-duration='{plan.duration!r}' style='{_TEXT}'>"
        f"<span style='font-size:24px;font-weight:600'>{plan.duration:.3f} s</span>{change} &nbsp;{badge}{note}"
        f"<div>{escape(plan.message)}</div><div style='color:#555'>{effort}</div></div>"
    )


def certificate_table(plan: Plan) -> str:
    """Every row of the certificate, the fullest limit first; the checks of the record in one line unless one fails."""
    certificate = plan.certificate
    rows = [row for row in certificate.rows if not (row.of_record and row.ok)]
    rows = sorted(rows, key=lambda row: (row.ok, -row.use))
    joints = plan.scene.robot.joints
    short = dict(zip(joints, short_names(joints), strict=True))
    cells = "".join(_certificate_row(row, short.get(row.label, row.label)) for row in rows)
    head = "".join(
        f"<th style='text-align:{side};padding:2px 4px;position:sticky;top:0;background:#fff'>{text}</th>"
        for text, side in _COLUMNS
    )
    return (
        f"<div id='nospill-certificate' style='max-height:62vh;overflow:auto;margin:4px 10px;border:1px solid #ddd'>"
        f"<table style='border-collapse:collapse;width:100%;font-size:12px;line-height:1.3;color:#222'>"
        f"<thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>"
        f"<div style='padding:2px 4px;font-size:12px'>{escape(integrity_line(certificate))}</div></div>"
    )


def _certificate_row(row: Row, name: str) -> str:
    text = row_text(row)
    red, green, blue = use_colours([row.use])[0]  # type: ignore[arg-type]
    mark = "" if row.ok else f";color:{_WRONG};font-weight:600"
    cell = "padding:2px 4px;border-top:1px solid #eee"
    right = f"{cell};text-align:right;white-space:nowrap"
    return (
        f"<tr style='{mark[1:]}' title='at t = {row.at_s:.3f} s'><td style='{cell}'>{escape(row.constraint)}</td>"
        f"<td style='{cell};overflow-wrap:anywhere'>{escape(name)}</td>"
        f"<td style='{right};border-right:5px solid rgb({red},{green},{blue})'>{text.use}</td>"
        f"<td style='{right}'>{text.value}</td><td style='{right}'>{escape(text.limit_and_unit)}</td></tr>"
    )


def file_note(text: str, *, wrong: bool = False) -> str:
    """What became of a file."""
    look = _WRONG if wrong else "#222"
    words = escape(text)
    return f"<div id='nospill-file' style='{_TEXT};color:{look};overflow-wrap:anywhere'>{words}</div>" if text else ""
