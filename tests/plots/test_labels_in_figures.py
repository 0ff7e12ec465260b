"""Figures and rows name objects by their labels."""

from __future__ import annotations

from dataclasses import replace

import matplotlib
from matplotlib.text import Text

from nospill.drawing.timeline import Film
from nospill.plots.evidence import evidence_of
from nospill.plots.figures import FIGURES
from nospill.plots.style import LOOK
from nospill.plots.tiles import carried
from nospill.scene.cargo import titles_of
from tests.films import mixed_film  # noqa: F401


def test_figures_and_rows_go_by_labels(mixed_film: Film) -> None:  # noqa: F811
    plan, judgement = mixed_film.plan, mixed_film.judgement
    box, cup, block = plan.scene.cargo
    scene = replace(plan.scene, cargo=(box, replace(cup, label="beer 0.3 l"), block))
    found = evidence_of(replace(plan, scene=scene), judgement)
    assert [item.name for item in found.plan.scene.cargo] == ["box", "beer 0.3 l", "block"]
    rows = {row.subject for row in found.judgement.certificate.rows}
    assert "beer 0.3 l" in rows and "cup" not in rows
    assert {trace.subject for trace in found.judgement.traces} >= {"beer 0.3 l", "block"}
    with matplotlib.rc_context(LOOK):
        for name in ("summary", "slosh-heights", "margins"):
            figure = FIGURES[name](found)
            assert figure is not None
            texts = [text.get_text() for text in figure.findobj(Text)]  # type: ignore[union-attr]
            assert "beer 0.3 l" in texts and "cup" not in texts
    assert evidence_of(plan, judgement).plan is plan


def test_a_label_that_two_have_is_told_apart(mixed_film: Film) -> None:  # noqa: F811
    box, cup, block = mixed_film.plan.scene.cargo
    titles = titles_of([replace(box, label="tea"), replace(cup, label="tea"), block])
    assert titles == {"box": "tea (box)", "cup": "tea (cup)", "block": "block"}


def test_what_the_tray_carries(mixed_film: Film) -> None:  # noqa: F811
    scene = mixed_film.plan.scene
    assert carried(scene) == "0.26 l, 0.73 kg"  # 80 x 50 x 45 mm and a cylinder of 25 mm radius filled to 40 mm
    assert carried(replace(scene, cargo=scene.cargo[2:])) == "0.4 kg"
