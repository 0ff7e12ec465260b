"""What the page says before any chart."""

from __future__ import annotations

from dataclasses import replace

from nospill.drawing.timeline import Film
from nospill.laws.constraints.base import RowId
from nospill.viewer.words import introduction


def test_a_plan_is_introduced_in_words(tilting_film: Film, level_film: Film) -> None:
    report = replace(tilting_film.plan.report, savings={RowId("joint speed", "joint_1").label: 0.05})
    film = replace(tilting_film, plan=replace(tilting_film.plan, report=report))
    alone = introduction([film])
    assert alone.startswith("<h1>matrix-liquid-tilt (tilting): ")
    assert "Comau Smart SiX 6-1.4 carries 4 open vessels (c1, c2, c3, c4);" in alone
    rows = film.judgement.certificate.rows
    failed = [row for row in rows if not row.ok]
    assert failed and f"{len(failed)} of {len(rows)} limits fail, first {failed[0].label}." in alone
    assert "<b>What would help:</b> a limit wider by 10 % would save about 0.05 s (speed of joint 1)" in alone
    both = introduction([level_film, film])
    assert both.count("<h1>") == 2
    assert "carries" not in both and "would save" not in both


def test_a_certified_plan_keeps_all_its_limits(mixed_film: Film) -> None:
    certificate = mixed_film.judgement.certificate
    held = replace(certificate, rows=tuple(row for row in certificate.rows if row.ok))
    film = replace(mixed_film, judgement=replace(mixed_film.judgement, certificate=held))
    text = introduction([film])
    assert "carries 2 open vessels and 1 loose object (box, cup, block); the fastest motion found" in text
    assert f"keeps all {len(held.rows)} limits: nothing spills, lifts, slides, tips or twists." in text
