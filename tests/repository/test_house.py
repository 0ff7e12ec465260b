"""The house rules: sizes, docstrings, pins, and a README that says what is true."""

from __future__ import annotations

import ast
import os
import re
import tomllib
from collections.abc import Container, Iterable, Iterator
from pathlib import Path

import pytest

import nospill
from nospill.cli import app
from nospill.laws.constraints import CONSTRAINTS
from nospill.scenario import scene_from_table

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "decisions").glob("*.md")),
]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PINS = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if line and not line.startswith("#")]


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


def make_targets() -> set[str]:
    return set(re.findall(r"^([a-z][a-z-]*):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_what_few_commands_need_is_loaded_where_it_is_used() -> None:
    """Each takes as long to load as all else of the commands that can do without."""
    late = re.compile(r"^(?:from|import) (?:scipy\.stats|matplotlib\.backends\.backend_pdf|fontTools)\b", re.MULTILINE)
    assert [str(path) for path in SOURCES if late.search(path.read_text(encoding="utf-8"))] == []
    assert late.search("import scipy.stats\n") and late.search("x\nfrom matplotlib.backends.backend_pdf import Op\n")


def test_no_file_is_over_500_lines() -> None:
    assert [label(path) for path in SOURCES + TESTS if len(path.read_text().splitlines()) > 500] == []


def test_every_public_module_says_what_it_is() -> None:
    public = [path for path in SOURCES if not path.stem.startswith("_") or path.stem == "__init__"]
    texts = {label(path): ast.get_docstring(ast.parse(path.read_text())) or "" for path in public}
    assert {name: text for name, text in texts.items() if len(text.split()) < 3} == {}
    assert not any(path.stem == "utils" for path in SOURCES)


def test_nothing_is_left_to_do() -> None:
    left = re.compile(r"\b(TODO|FIXME|XXX)\b")
    others = [path for path in SOURCES + TESTS + PAGES if path != Path(__file__)]  # which names what it looks for
    assert [label(path) for path in others if left.search(path.read_text())] == []


def unknown(known: Container[str], *patterns: str, paths: Iterable[Path] = PAGES) -> dict[str, list[str]]:
    """By page what the patterns find in it and is not known."""
    found = {label(path): re.findall("|".join(patterns), path.read_text(), flags=re.MULTILINE) for path in paths}
    assert any(found.values())
    named = {page: ["".join(groups) for groups in words] for page, words in found.items()}
    return {page: wrong for page, words in named.items() if (wrong := [word for word in words if word not in known])}


def test_make_commands_in_the_pages_exist() -> None:
    patterns = (r"^\s*(?:\$ )?make ([a-z][a-z-]*)", r"`make ([a-z][a-z-]*)")
    assert unknown(make_targets(), *patterns, paths=[*PAGES, ROOT / ".ci" / "run"]) == {}


def test_readme_names_the_two_commands() -> None:
    text = (ROOT / "README.md").read_text()
    assert "    make demo\n    make test\n" in text
    assert {"demo", "test", "test-fast", "check", "format", "build", "clean"} <= make_targets()


def goals(text: str) -> list[str]:
    """Targets that make is called with, in order; setting up an environment alone is none."""
    calls = re.findall(r"^\s*(?:- run: |time )?make ((?:-\S+ )*[a-z .\-/]+?)\s*(?:\||  #|$)", text, flags=re.MULTILINE)
    words = (word for call in calls for word in call.split())
    return [word for word in words if not word.startswith(("-", "."))]


def test_continuous_integration_runs_the_two_commands_of_the_readme_first() -> None:
    script = ROOT / ".ci" / "run"
    text = script.read_text()
    assert os.access(script, os.X_OK)
    assert "set -euo pipefail" in text
    assert goals(text) == ["demo", "test", "check", "docs", "robots", "build"]
    # Before anything else is installed into any environment, and the tests' closing lines end the log.
    assert text.index("make test") < text.index("make .venv-check")
    assert text.splitlines()[-1].startswith("tail ") and text.splitlines()[-1].endswith("out/test.log")


def test_the_visible_workflow_calls_the_same_targets() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text()
    assert goals(workflow) == goals((ROOT / ".ci" / "run").read_text())


def test_tests_linter_and_documentation_have_environments_of_their_own() -> None:
    text = (ROOT / "Makefile").read_text()
    rules = dict(re.findall(r"^\$\(([A-Z]+)\)/\.ready: EXTRAS := (\S+)$", text, re.MULTILINE))
    assert rules == {"VENV": "test", "ROBOTS": "test", "CHECK": "test,dev", "DOCS": "test,docs"}
    places = dict(re.findall(r"^(VENV|CHECK|DOCS|ROBOTS) [:?]= (\S+)$", text, re.MULTILINE))
    assert len(set(places.values())) == 4 and places["VENV"] == ".venv"


def test_nospill_commands_in_the_pages_exist() -> None:
    known = {command.callback.__name__.replace("_", "-") for command in app.registered_commands if command.callback}
    assert unknown(known, r"(?:`|\.venv/bin/)nospill ([a-z-]+)") == {}


def test_links_between_the_pages_hold() -> None:
    links = [(path, target) for path in PAGES for target in re.findall(r"\]\(([^)#]+)", path.read_text())]
    broken = [(label(path), to) for path, to in links if "://" not in to and not (path.parent / to).exists()]
    assert broken == [] and len(links) > len(PAGES)


@pytest.mark.parametrize("page", ["README.md", "docs/scenario-guide.md"])
def test_scenario_of_the_page_can_be_planned(page: str) -> None:
    blocks = re.findall(r"```toml\n(.*?)```", (ROOT / page).read_text(), flags=re.DOTALL)
    assert len(blocks) == 1
    scene = scene_from_table(tomllib.loads(blocks[0]), name="tea")
    assert [cargo.name for cargo in scene.cargo] == ["c1"]


def test_files_named_in_the_pages_exist() -> None:
    package = ROOT / "src" / "nospill"
    added = (ROOT / "docs" / "examples" / "extending").glob("*/nospill")  # by the worked examples
    folders = (ROOT, ROOT / "src", package, package / "laws" / "constraints", *added)
    named = [
        (path, name) for path in PAGES for name in re.findall(r"`((?:[a-z_-]+/)*[a-z_0-9]+\.py)`", path.read_text())
    ]
    missing = [(label(path), name) for path, name in named if not any((folder / name).exists() for folder in folders)]
    assert missing == [] and named


def test_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text().split()) <= 1200


def test_certificate_page_explains_every_constraint() -> None:
    text = (ROOT / "docs" / "reading-a-certificate.md").read_text()
    table = text[text.index("## The rows") : text.index("## An example")]
    explained = {
        name.strip() for first in re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE) for name in first.split(",")
    }
    assert {constraint.name for constraint in CONSTRAINTS} <= explained


def test_constraints_file_names_versions_and_no_index() -> None:
    assert PINS
    for line in PINS:
        assert re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!]+", line), line
    names = [canonical(line.split("==")[0]) for line in PINS]
    assert len(names) == len(set(names))


def wanted() -> Iterator[str]:
    project = PROJECT["project"]
    for requirements in (project["dependencies"], *project["optional-dependencies"].values()):
        names = (canonical(re.split(r"[\[<>=!~; ]", requirement)[0]) for requirement in requirements)
        yield from (name for name in names if name != "nospill")  # an extra that takes in others


def test_every_direct_dependency_is_pinned() -> None:
    assert set(wanted()) - {canonical(line.split("==")[0]) for line in PINS} == set()
    assert {"numpy", "casadi"} <= set(wanted())


def test_no_index_is_named_anywhere_in_the_set_up() -> None:
    for name in ("Makefile", ".ci/run", ".github/workflows/ci.yml", "constraints.txt", "pyproject.toml"):
        text = (ROOT / name).read_text()
        assert not re.search(r"index-url|find-links|trusted-host|://", text), name


def test_licence_is_the_one_declared() -> None:
    assert PROJECT["project"]["license"] == "Apache-2.0"
    text = (ROOT / "LICENSE").read_text()
    assert "Apache License" in text
    assert "Version 2.0, January 2004" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_changelog_has_the_version_with_its_date_and_none_is_long() -> None:
    _, *versions = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(), flags=re.MULTILINE)
    titles = [version.splitlines()[0] for version in versions]
    assert titles[0] == "[Unreleased]"
    assert all(re.fullmatch(r"\[\d+\.\d+\.\d+\] - \d{4}-\d\d-\d\d", title) for title in titles[1:])
    assert titles[1].startswith(f"[{nospill.__version__}]")
    assert max(map(len, versions)) <= 9000
