"""Free labels of objects: any text of one line, kept with the plan, with no say in the motion."""

from __future__ import annotations

import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table


def labelled(text: object) -> dict[str, object]:
    return changed_table(read_scenario("pp-two-cups").source, {"cargo.0.label": text})


@pytest.mark.parametrize("text", ["beer 0.3 l", "Weißbier, groß", "茶", "a" * 60])
def test_any_text_of_one_line_is_a_label(text: str) -> None:
    scene = scene_from_table(labelled(text), name="bar")
    assert (scene.cargo[0].name, scene.cargo[0].title, scene.cargo[1].title) == ("left", text, "right")
    assert text in scene.text()


@pytest.mark.parametrize("text", ["a" * 61, "two\nlines", "\x07", 3, ["a"]])
def test_what_is_no_text_of_one_line_is_refused(text: object) -> None:
    with pytest.raises(ScenarioError, match=r"label .* is no text of one line; use at most 60"):
        scene_from_table(labelled(text), name="bar")
