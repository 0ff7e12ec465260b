"""What the studio writes in the browser: the answer, warnings, certificate, faults, as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from nospill.certification.height_order import height_sentence
from nospill.certification.verdict import Row
from nospill.certification.wording import integrity_line, row_text
from nospill.core.short_names import short_names
from nospill.drawing.colours import use_colours
from nospill.plans.plan import Plan
from nospill.plans.warnings.record import PlanWarning, warning_lines
from nospill.studio.checks import Fault
from nospill.studio.fields import in_words
from nospill.studio.page_script import WRONG
from nospill.studio.planning import BUSY, PlanningState

_TEXT = "padding:2px 10px;font-size:13px;line-height:1.4;color:#222"
_LARGE, _GOOD, _BAD, _OLD = "font-size:24px;font-weight:600", "#00684D", "#A63C00", "#6b6b6b"
_SCROLLED = "height:76px;overflow:auto;overflow-wrap:anywhere;box-sizing:border-box"
_MOST_FAULTS = 8
_COLUMNS = (("constraint", "left"), ("of", "left"), ("use of limit", "right"), ("value", "right"), ("limit", "right"))
_PHASES = {
    "start": "starting",
    "ends": "ends of the path",
    "kinematics": "joint paths",
    "build": "building the problem",
    "solve": "solving",
    "export": "writing the samples",
    "certify": "judging",
}


def fault_list(faults: Sequence[Fault]) -> str:
    """Every fault with its place, below the button that they disable."""
    if not faults:
        return ""
    lines = [f"<li>{escape(in_words(fault.sentence))}</li>" for fault in faults[:_MOST_FAULTS]]
    more = f"<li>and {len(faults) - _MOST_FAULTS} more</li>" if len(faults) > _MOST_FAULTS else ""
    return (
        f"<div id='nospill-faults' style='color:{WRONG}'>"
        f"<ul style='margin:0;padding-left:18px'>{''.join(lines)}{more}</ul></div>"
    )


def obstacle_note(obstacle: str) -> str:
    """What is in the way of the arm on this path, below the button that it disables; empty without any."""
    if not obstacle:
        return ""
    return f"<div id='nospill-obstacle' role='alert' style='color:{WRONG}'>{escape(obstacle)}</div>"


def headline(
    state: PlanningState,
    plan: Plan | None,
    *,
    previous: bool,
    before: float | None,
    faults: int = 0,
    reach: bool = True,
) -> str:
    """The answer in a line or two, which stays in sight: where planning stands, duration and verdict, or why not.

    Args:
        state: of planning the scenario on the screen.
        plan: the last one.
        previous: whether it is of another scenario, or the last attempt came to nothing.
        before: duration of the plan before it, s.
        faults: how many values are wrong.
        reach: whether the arm reaches the path.
    """
    if state.stage in BUSY:
        lines = _progress(state)
    else:
        wrong = "1 value" if faults == 1 else f"{faults} values"
        lines = f"<b style='color:{WRONG}'>{wrong} to correct before planning</b>" if faults else ""
        if not faults and not reach:
            lines = f"<b style='color:{WRONG}'>The arm does not reach this path.</b>"
        elif state.stage == "failed" and not faults:
            lines = f"<span style='{_LARGE};color:{_BAD}'>no motion</span> &nbsp;{_badge('failed', _BAD)}"
        if plan is not None and previous:
            lines += f"<div id='nospill-previous' style='color:{_OLD}'>{_previous(plan)}</div>"
        elif plan is not None and not lines:
            lines = _verdict(plan, before)
        lines = lines or f"<span style='color:{_OLD}'>nothing is planned yet</span>"
    return f"<div id='nospill-headline' style='{_TEXT};height:56px;overflow:hidden'>{lines}</div>"


def details(
    state: PlanningState,
    plan: Plan | None,
    *,
    previous: bool,
    faults: Sequence[Fault] = (),
    obstacle: str = "",
    about: str = "",
) -> str:
    """What there is to say of the answer, below its headline: always of one height, or a drag would move the tray.

    Args:
        state: as in `headline`, likewise `plan` and `previous`.
        plan: see there.
        previous: see there.
        faults: what is wrong.
        obstacle: what is in the way of the arm.
        about: a line about the scenario, for the time when there is nothing else to say.
    """
    if faults:
        text = fault_list(faults)
    elif obstacle:
        text = obstacle_note(obstacle)
    elif state.stage in ("failed", "stopped"):
        text = escape(in_words(state.message))
    elif plan is None or previous or state.stage in BUSY:
        changed = "The scenario was changed since; Plan answers anew." if plan and state.stage not in BUSY else about
        text = f"<span style='color:#555'>{escape(changed)}</span>"
    else:
        report, count = plan.report, len(warning_lines(plan.warnings))
        more = f" {'1 warning' if count == 1 else f'{count} warnings'}: see Certificate." if count else ""
        text = (
            f"{escape(plan.message)}{more}{escape(height_sentence(plan.scene))} "
            f"<span style='color:#555'>Planned in {report.plan_time:.2f} s, "
            f"{report.iterations} iterations.</span>"
        )
    return f"<div id='nospill-details' tabindex='-1' style='{_TEXT};{_SCROLLED}'>{text}</div>"


def _progress(state: PlanningState) -> str:
    words = {"waiting": "waiting for another plan to end", "stopping": "stopping"}.get(
        state.stage, _PHASES.get(state.phase, state.phase)
    )
    figures = [
        f"iteration {state.iteration}" if state.iteration is not None else "",
        f"duration {state.duration_s:.3f} s" if state.duration_s is not None else "",
        f"violation {state.violation:.1e}" if state.violation is not None else "",
    ]
    return (
        f"<div id='nospill-progress'><b>{escape(words)}</b> <span style='color:#555'>{state.seconds:.1f} s</span><br>"
        f"<span style='font-variant-numeric:tabular-nums'>{' · '.join(filter(None, figures)) or '&nbsp;'}</span></div>"
    )


def _verdict(plan: Plan, before: float | None) -> str:
    """Duration and verdict in large letters."""
    change = (
        "" if before is None else f" <span style='font-size:13px;color:#555'>({plan.duration - before:+.3f} s)</span>"
    )
    badge = _badge(plan.certificate.word, _GOOD if plan.certificate.ok else _BAD)
    duration = f"<span style='{_LARGE}'>{plan.duration:.3f} s</span>"
    return f"<div id='nospill-verdict' data-duration='{plan.duration!r}'>{duration}{change} &nbsp;{badge}</div>"


def _previous(plan: Plan) -> str:
    """A plan that is not of the scenario on the screen: nobody may take it for the answer."""
    return f"previous: {plan.duration:.3f} s, {plan.certificate.word}"


def _badge(word: str, colour: str) -> str:
    return (
        f"<span id='nospill-status' style='font-size:13px;font-weight:600;padding:2px 8px;border-radius:9px;color:#fff;"
        f"background:{colour}'>{word}</span>"
    )


def warning_list(warnings: Sequence[PlanWarning]) -> str:
    """What a plan rests on beyond its limits; empty where there is nothing to say."""
    lines = "".join(f"<li>{escape(line)}</li>" for line in warning_lines(warnings))
    if not lines:
        return ""
    return (
        f"<div id='nospill-warnings' style='{_TEXT};overflow-wrap:anywhere'><b>Warnings</b>"
        f"<ul style='margin:2px 0 0 0;padding-left:18px'>{lines}</ul></div>"
    )


def certificate_table(plan: Plan, *, previous: bool = False) -> str:
    """Every row of the certificate, the fullest limit first; the checks of the record in one line unless one fails.

    Args:
        plan: what was planned.
        previous: whether it is not of the scenario on the screen, which is said and greyed.
    """
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
    note = f"<div style='padding:2px 10px;font-size:13px;color:{_OLD}'>Of the previous plan.</div>" if previous else ""
    return (
        f"{note}<div id='nospill-certificate' style='max-height:62vh;overflow:auto;margin:4px 10px;"
        f"border:1px solid #ddd{';opacity:0.5' if previous else ''}'>"
        f"<table style='border-collapse:collapse;width:100%;font-size:12px;line-height:1.3;color:#222'>"
        f"<thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>"
        f"<div style='padding:2px 4px;font-size:12px'>{escape(integrity_line(certificate))}</div></div>"
    )


def _certificate_row(row: Row, name: str) -> str:
    text = row_text(row)
    red, green, blue = use_colours([row.use])[0]  # type: ignore[arg-type]
    mark = "" if row.ok else f";color:{WRONG};font-weight:600"
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
    look = WRONG if wrong else "#222"
    words = escape(text)
    return f"<div id='nospill-file' style='{_TEXT};color:{look};overflow-wrap:anywhere'>{words}</div>" if text else ""
