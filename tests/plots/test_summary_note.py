"""What the full model sees stands on the summary sheet where the plan was judged by less."""

from __future__ import annotations

from dataclasses import replace

import matplotlib
from matplotlib.text import Text

from nospill.certification.certificate import judge
from nospill.certification.wording import full_model_note
from nospill.plots.evidence import Evidence
from nospill.plots.style import LOOK
from nospill.plots.summary import summary_figure


def test_summary_says_what_the_full_model_sees(gentle_plan) -> None:
    plan = gentle_plan("matrix-liquid", cargo=1)
    judgement = judge(plan.trajectory, plan.scene)
    row = next(row for row in judgement.certificate.rows if row.constraint == "slosh height")
    beyond = replace(row, worst_value=1.2 * row.limit, worst_margin=-0.2 * row.limit, ok=False)
    for seen in ((), (beyond,)):
        certificate = replace(judgement.certificate, full_model=seen)
        note = full_model_note(certificate)
        assert ("20 % over its limit" in note) == bool(seen)
        with matplotlib.rc_context(LOOK):
            figure = summary_figure(Evidence(plan, replace(judgement, certificate=certificate)))
        texts = [item.get_text() for item in figure.findobj(Text) if isinstance(item, Text)]
        assert any(text.startswith("the full model sees") for text in texts) == bool(seen)
        assert not seen or note in texts
