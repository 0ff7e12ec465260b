"""Pictures of the pages: each is on a page, each page names pictures that exist, and they can be drawn."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from nospill_docs.gallery import write_gallery  # noqa: F401  (the package imports its parts in this order)
from nospill_docs.pictures import PICTURES
from nospill_docs.pictures.paper import look, write

DOCS = Path(__file__).parents[3] / "docs"
_DRAWN = re.compile(r"^(?:```\{figure\} |!\[.*\]\()(\S+?)\)?$", re.MULTILINE)


def _pictures() -> dict[Path, list[str]]:
    """Pictures of every page that is kept, by page."""
    pages = [path for path in DOCS.rglob("*.md") if not {"_generated", "_build"} & set(path.relative_to(DOCS).parts)]
    return {page: _DRAWN.findall(page.read_text(encoding="utf-8")) for page in pages}


def test_every_picture_is_on_a_page_and_every_name_on_a_page_is_a_picture() -> None:
    named = {Path(name).name for found in _pictures().values() for name in found if "_generated/pictures" in name}
    assert named == {f"{name}{picture.suffix}" for name, picture in PICTURES.items()}


def test_at_least_25_pages_show_what_they_speak_of() -> None:
    # The pages of the gallery and of the notebooks are made by the build and left out here.
    shown = [page for page, found in _pictures().items() if found and not page.name[0].isdigit()]
    assert len(shown) >= 25


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, picture in PICTURES.items() if not picture.plans])
def test_a_picture_that_needs_no_plan_is_drawn_the_same_twice(name: str, tmp_path: Path) -> None:
    with look():
        for number in (1, 2):
            figure = PICTURES[name].draw()
            assert isinstance(figure, Figure)
            assert figure.get_size_inches()[0] == pytest.approx(7.4), "as wide as a page's text"
            write(figure, tmp_path / f"{number}.svg")
    first, second = ((tmp_path / f"{number}.svg").read_text(encoding="utf-8") for number in (1, 2))
    assert first == second
