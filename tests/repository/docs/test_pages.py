"""Pages that speak of what the program does are held to it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import nbformat  # pyright: ignore[reportMissingImports]  (an extra of the documentation, where these tests run)
import pytest
from nospill_docs import screens
from nospill_docs.formulas import formula
from nospill_docs.links import broken_links
from nospill_docs.notebooks import to_markdown
from nospill_docs.pages import as_of_the_site, contents
from nospill_docs.places import Places
from nospill_docs.transcripts import session

from nospill.certification.certificate import certify
from nospill.errors import NoSolutionError, ScenarioError
from nospill.planning.planner import plan
from nospill.scenario import read_scenario

DOCS = Path(__file__).parents[3] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def test_every_row_of_a_certificate_is_explained(smooth_motion: Callable[..., object]) -> None:
    page = (DOCS / "reading-a-certificate.md").read_text(encoding="utf-8")
    motion = smooth_motion("pp-two-cups")
    rows = certify(motion.trajectory, motion.scene).rows  # type: ignore[attr-defined]
    for name in {row.constraint for row in rows}:
        assert re.search(rf"^\| [^|]*\b{name}\b[^|]*\|", page, re.MULTILINE), name


def test_a_notebook_is_executed_without_importing_ipython_beside_the_figures(tmp_path: Path) -> None:
    """The figures are drawn in another thread, where matplotlib fails on an IPython that is imported in part."""
    program = (
        "import sys; from pathlib import Path; import nbformat; from nospill_docs.notebooks import execute;"
        "v4 = nbformat.v4; text = nbformat.writes(v4.new_notebook(cells=[v4.new_code_cell('print(6 * 7)')]));"
        "before = set(sys.modules); done = execute(text, Path(sys.argv[1])); new = set(sys.modules) - before;"
        "print(done.cells[0].outputs[0].text.strip(), [name for name in new if name.split('.')[0] == 'IPython'])"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], env=environment, text=True, capture_output=True, check=False
    )
    assert done.stdout.strip() == "42 []", done.stderr


@pytest.mark.slow
def test_the_two_cups_of_get_started_are_certified() -> None:
    found = plan(read_scenario(DOCS / "examples" / "two-cups.toml"))
    assert found.certificate.ok
    # What holds it back: slip, and the liquids, whose back-off, by the flow too, leaves a little (0131);
    # not the arm's speed.
    use = {row.constraint: row.use for row in found.certificate.worst_rows()}
    assert use["slip"] > 0.98 and max(use["slosh height"], use["residual height"]) > 0.90
    assert max(use["joint speed"], use["joint position"]) < 0.98


@pytest.mark.parametrize("name", ["misspelt", "overfull"])
def test_the_bad_scenarios_are_refused_in_one_line(name: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        read_scenario(DOCS / "examples" / f"{name}.toml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "error"), [("out-of-reach", ScenarioError), ("impossible", NoSolutionError)])
def test_the_impossible_scenarios_get_a_reason(name: str, error: type[Exception]) -> None:
    with pytest.raises(error, match=r"out of reach|max_duration"):
        plan(read_scenario(DOCS / "examples" / f"{name}.toml"))


def test_the_variants_differ_from_the_scenario_in_one_place_only() -> None:
    base = (DOCS / "examples" / "two-cups.toml").read_text(encoding="utf-8").splitlines()[1:]
    for name in ("misspelt", "overfull", "out-of-reach", "impossible"):
        variant = (DOCS / "examples" / f"{name}.toml").read_text(encoding="utf-8").splitlines()[1:]
        assert len(set(variant) - set(base) - {"[motion]"}) == 1, name
    tomllib.loads("\n".join(base))


def test_a_session_shows_command_message_and_exit_code(tmp_path: Path) -> None:
    shown = session(("nospill plan nothing.toml",), tmp_path)
    assert shown.startswith("$ nospill plan nothing.toml\nnothing.toml: no such file")
    assert shown.endswith("(exit code 2)\n")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_kept_without_outputs(path: Path) -> None:
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None


def test_an_executed_notebook_becomes_a_page() -> None:
    cell = nbformat.v4.new_code_cell("print(6 * 7)")
    picture = nbformat.v4.new_output("display_data", data={"image/png": "aGVsbG8=", "text/plain": "<Figure>"})
    cell.outputs = [nbformat.v4.new_output("stream", name="stdout", text="42\n"), picture]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("# Title"), cell])
    page, pictures = to_markdown(notebook)
    assert page.startswith("# Title\n\n```python\nprint(6 * 7)\n```\n\n```text\n42\n```\n\n![")
    assert pictures == {"figure-1.png": b"hello"}


def test_formulas_are_outlines_and_unknown_ones_are_reported() -> None:
    drawn = formula(r"\ddot q \le \frac{1}{2}", "inline")
    assert drawn.startswith("<svg") and "<path" in drawn and "currentColor" in drawn
    with pytest.raises(ValueError, match="Unknown symbol"):
        formula(r"\nosuchsymbol", "block")


def test_links_that_lead_nowhere_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<a href="b.html#there">1</a><a href="b.html#gone">2</a><a href="c.html">3</a>')
    (tmp_path / "b.html").write_text('<p id="there"><a href="https://elsewhere.invalid/">4</a></p>')
    assert broken_links(tmp_path) == [("a.html", "b.html#gone"), ("a.html", "c.html")]


def test_contents_of_an_index_are_the_pages_it_leads_to() -> None:
    text = "# A\n\n- [x](../x.md)\n- [b](b.md#part): b\n\n## C\n\n| 1 | [d](d.md) |\nno [e](e.md)\n1. [f](f/g.md)\n"
    first, second = contents(text)
    assert "caption" not in first and first.endswith("\n\nb\n```\n")
    assert ":caption: C\n" in second and second.endswith("\n\nd\nf/g\n```\n")


def test_the_site_shows_more_than_a_clone() -> None:
    page = as_of_the_site("reference/python", "<!-- made: python nospill.plan -->\n\n- plan\n\n<!-- end -->\n")
    assert page == "```{eval-rst}\n.. autofunction:: nospill.plan\n\n```\n\n"
    assert as_of_the_site("faq", "[n](notebooks/limits.ipynb)") == "[n](notebooks/limits.md)"
    assert as_of_the_site("faq", "[notes](../benchmarks/notes/x.md).") == "notes (`benchmarks/notes/x.md`)."
    gallery = as_of_the_site("gallery/index", (DOCS / "gallery" / "index.md").read_text(encoding="utf-8"))
    assert "_generated/gallery.md" in gallery and "[0-9]*" in gallery and "| example |" not in gallery


def test_results_are_made_once_and_anew_when_their_key_changes(tmp_path: Path) -> None:
    places, made = Places.of(tmp_path), []

    def make(folder: Path) -> None:
        made.append(folder)
        (folder / "x").write_text("x")

    first = places.cached("thing", "key", make)
    assert places.cached("thing", "key", make) == first and len(made) == 1
    second = places.cached("thing", "other key", make)
    assert len(made) == 2 and second != first and not first.exists()


def test_pages_of_pictures_do_without_a_browser(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(screens, "BROWSERS", ("no-such-browser",))
    places = Places.of(tmp_path)
    screens.write_screens(places)
    for page in ("studio", "viewer"):
        assert "missing" in (places.generated / f"screens-{page}.md").read_text(encoding="utf-8")
        whole = as_of_the_site(page, (DOCS / f"{page}.md").read_text(encoding="utf-8"))
        assert f"_generated/screens-{page}.md" in whole
