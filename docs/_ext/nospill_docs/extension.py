"""The Sphinx extension: makes pictures, plans and notebooks at the start, reads pages as the site shows them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

from sphinx.application import Sphinx

from nospill_docs.formulas import add_formulas
from nospill_docs.gallery import write_gallery
from nospill_docs.links import check_links
from nospill_docs.notebooks import write_notebooks
from nospill_docs.pages import as_of_the_site
from nospill_docs.pictures import write_pictures
from nospill_docs.places import Places
from nospill_docs.screens import write_screens


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the generators, the mathematics and the check of the links."""
    add_formulas(app)
    app.connect("builder-inited", _generate)
    app.connect("source-read", _read)
    app.connect("autodoc-process-docstring", _plain_words, priority=100)
    app.connect("build-finished", check_links)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _generate(app: Sphinx) -> None:
    places = Places.of(app.srcdir)
    write_gallery(places)
    with ThreadPoolExecutor(max_workers=1) as pool:  # notebooks and screens are the work of other processes
        others = pool.submit(lambda: [write(places) for write in (write_notebooks, write_screens)])
        write_pictures(places)
        others.result()


def _read(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = as_of_the_site(page, source[0])


def _plain_words(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Keep sentences what they are, before napoleon reads them.

    Docstrings write absolute values as |x|, which reStructuredText would take for substitutions. Types stand in the
    annotations, so what precedes a colon in a "Returns:" section is no type, nor in a property's first line, where a
    dash takes its place.
    """
    lines[:] = [line.replace("|", r"\|").replace("Returns:", "Return value:") for line in lines]
    if what == "property" and lines:
        lines[0] = lines[0].replace(": ", " - ", 1)
