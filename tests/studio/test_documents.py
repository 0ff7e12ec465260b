"""Opening, saving, uploads, downloads."""

from __future__ import annotations

import io
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.studio import documents
from nospill.studio.draft import Draft
from tests.builders import plan_for


def test_what_was_saved_is_opened_again(tmp_path: Path, table: dict[str, Any]) -> None:
    draft = Draft(table)
    draft.change({("name",): "mine", ("cargo", 0, "liquid_height"): "45 mm", ("planning", "slosh_modes"): 1})
    path = documents.save_scenario(scene_from_table(draft.table, name="studio"), tmp_path)
    assert path == tmp_path / "mine.toml"
    assert tomllib.loads(path.read_text()) == draft.table
    assert documents.scenario_choices(tmp_path) == (*EXAMPLES, "mine.toml")
    assert documents.open_scenario("mine.toml", tmp_path) == draft.table
    assert documents.open_scenario("matrix-liquid", tmp_path) == read_scenario("matrix-liquid").source


def test_only_scenario_files_are_offered(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text("[build-system]\nrequires = []\n")
    (tmp_path / "broken.toml").write_text("[robot]\n[tray]\nsize = ")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe[robot]")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "later.toml").write_text('[robot]\nmodel = "?"\n[tray]\n')
    assert documents.scenario_choices(tmp_path) == (*EXAMPLES, "later.toml")
    assert documents.scenario_choices(tmp_path / "nowhere") == tuple(EXAMPLES)


@pytest.mark.parametrize("choice", ["../mine.toml", "/etc/passwd", "nothing.toml", ""])
def test_only_what_is_offered_is_opened(tmp_path: Path, choice: str) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "mine.toml").write_text("")
    with pytest.raises(ScenarioError, match="no scenario of that name"):
        documents.open_scenario(choice, tmp_path / "inner")


def test_a_wrong_file_says_what_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("[robot]\n[tray]\nsize = 3\n")
    with pytest.raises(ScenarioError, match="size"):
        documents.open_scenario("bad.toml", tmp_path)


def test_an_upload_is_read_like_a_file(table: dict[str, Any]) -> None:
    scene = scene_from_table(table, name="small")
    assert documents.read_upload("x.toml", scene.text().encode()) == scene.source


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"\xff\xfe", "is not a scenario file"),
        (b"a = ", "is not a scenario file"),
        (b"", "missing"),
        (b'[robot]\nurdf = "/etc/passwd"\n', "names another file"),
        (b'[path]\nfile = "../points.csv"\n', "names another file"),
        (b"a" * 10_000_001, "too large"),
    ],
)
def test_a_wrong_upload_is_refused(content: bytes, says: str) -> None:
    with pytest.raises(ScenarioError, match=says) as caught:
        documents.read_upload("given.toml", content)
    assert "given" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.slow
def test_exports_are_what_the_command_line_writes(tmp_path: Path, example_plan: Callable[[str], Plan]) -> None:
    plan = example_plan("matrix-rigid")
    for choice in documents.export_choices():
        found = documents.export_plan(plan_for(plan, choice), choice)
        assert found.content and found.name.startswith("matrix-rigid")
        if choice == documents.PLAN_FOLDER:
            with zipfile.ZipFile(io.BytesIO(found.content)) as archive:
                archive.extractall(tmp_path)
            assert load_plan(tmp_path / "matrix-rigid").duration == plan.duration
        elif not EXPORTERS[choice].suffixes[0].startswith("."):
            assert found.name.endswith(".zip")
        assert plan.status == "certified as published" and "ertified" in found.message
    with pytest.raises(ScenarioError, match="this one is comau-smart-six"):
        documents.export_plan(plan, "urscript")
