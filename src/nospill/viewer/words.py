"""What a page of the viewer says of a plan before any chart: verdict, what is shown, what holds it back."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from nospill.certification.limiting import limiting_rows, limiting_text
from nospill.drawing.timeline import Film
from nospill.plans.records import GIVEN
from nospill.scene.cargo import titles_of
from nospill.scene.scene import Scene

INTRODUCTION = "nospill-introduction"
"""Class of the element that `introduction` stands in."""
STYLE = (
    f".{INTRODUCTION} h1{{font:600 15px/1.35 system-ui,sans-serif;margin:0 0 4px;color:#222}}"
    f".{INTRODUCTION} p{{font:12px/1.4 system-ui,sans-serif;margin:0 0 5px;color:#222}}"
    # viser fades its scene in while it draws; a motion that is stopped meanwhile would stay pale
    "#root canvas{opacity:1!important}"
)
"""Style sheet of a page with that element."""
_MOST_NAMED = 4
"""Objects that are named one by one."""


def title_of(film: Film) -> str:
    """A plan in a few words: how the tray may move, how long it takes, the verdict on the motion that is shown."""
    scene = film.plan.scene
    kind = "level" if scene.stays_level else "tilting"
    verdict = film.judgement.certificate.word
    return f"{scene.name} ({kind}): {film.end_time:.3f} s, {verdict}"


def introduction(films: Sequence[Film]) -> str:
    """Titles and what one has to know of each plan, as HTML; of several plans only what holds each one back."""
    return "".join(f"<h1>{escape(title_of(film))}</h1>{_sentences(film, alone=len(films) == 1)}" for film in films)


def _sentences(film: Film, *, alone: bool) -> str:
    joints = film.plan.scene.robot.joints
    back = limiting_text(
        {item.row.label: item.share for item in limiting_rows(film.judgement, film.plan.scene)}, joints
    )
    sentences = [_facts_text(film)] if alone else []
    if back:
        sentences.append(f"<b>What holds it back:</b> {escape(back)}.")
    saved = film.plan.savings_text
    if saved and alone:
        sentences.append(f"<b>What would help:</b> {escape(saved)}.")
    return "".join(f"<p>{sentence}</p>" for sentence in sentences)


def _facts_text(film: Film) -> str:
    scene, certificate = film.plan.scene, film.judgement.certificate
    count = len(certificate.rows)
    if certificate.ok:
        kind = "the fastest motion found" if scene.motion.duration is None else "the gentlest motion of this duration"
        kind = kind if film.plan.report.solver_status != GIVEN else "a motion"
        spills = "spills, " if film.liquids else ""
        said = f"{kind} that keeps all {count} limits"
        said += f": nothing {spills}lifts, slides, tips or twists" if scene.cargo else ""
    else:
        failed = [row.label for row in certificate.rows if not row.ok]
        missing = [f'"{limit.name}" was not judged' for limit in certificate.unjudged]
        said = f"{len(failed)} of {count} limits fail, first {[*failed, *missing][0]}"
    return escape(f"{scene.robot.title} carries {_load(scene)}; {said}.")


def _load(scene: Scene) -> str:
    """What the tray carries: how many of what, and their names where they are few."""
    names = list(titles_of(scene.cargo).values())
    open_ones = sum(item.filling is not None for item in scene.cargo)
    counts = ((open_ones, "open vessel"), (len(names) - open_ones, "loose object"))
    parts = [f"{count} {kind}{'s' if count > 1 else ''}" for count, kind in counts if count]
    named = f" ({', '.join(names)})" if len(names) <= _MOST_NAMED else ""
    return f"{' and '.join(parts)}{named}" if parts else "an empty tray"
