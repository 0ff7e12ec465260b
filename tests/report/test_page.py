"""The page: valid, self-contained, harmless whatever the names, and saying what the certificate says."""

from __future__ import annotations

import base64
import io
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from nospill.certification.verdict import Row
from nospill.certification.wording import row_text
from nospill.plans.plan import Plan
from nospill.plots.report_pages import report_svgs
from nospill.plots.text_pages import TextTable
from nospill.report import Report, make_report
from nospill.report.contents import _beyond
from nospill.report.page import _bar, _table, html_page
from nospill.report.scene_picture import scene_picture

VOID = {"meta", "img", "br", "link", "hr", "input"}
LARGEST = 3_000_000


class Strict(HTMLParser):
    """Reads a page and refuses tags that are not closed, or closed in another order."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.ids: list[str] = []
        self.text: list[str] = []
        self.cells: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), (tag, names)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "xlink:href")]
        self.ids += [value or "" for name, value in attrs if name == "id"]
        if tag in ("td", "th"):
            self.cells.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, (tag, self.open[-4:], self.getpos())
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text.append(data)
        if self.cells and ("td" in self.open or "th" in self.open):
            self.cells[-1] += data


def read(page: str) -> Strict:
    parser = Strict()
    parser.feed(page)
    parser.close()
    assert parser.open == []
    return parser


@pytest.fixture(scope="module")
def hostile_page(hostile_plan: Plan) -> str:
    report = make_report(hostile_plan)
    return html_page(report, report_svgs(report.evidence))


@pytest.fixture(scope="module")
def fast_page(fast_report: Report) -> str:
    return html_page(fast_report, {})


def test_page_is_valid_self_contained_and_small(hostile_page: str) -> None:
    found = read(hostile_page)
    assert hostile_page.startswith("<!DOCTYPE html>")
    assert len(hostile_page.encode()) < LARGEST
    assert found.addresses and all(place.startswith("data:image/svg+xml;base64,") for place in found.addresses)
    assert not {"script", "link", "iframe", "object", "base", "form"} & set(found.tags)
    assert len(found.ids) == len(set(found.ids))
    assert "default-src 'none'" in hostile_page
    assert not re.search(r"url\(|@import|on(load|error|click)=", hostile_page.split("</style>")[0])
    assert next(tag for tag in found.tags if tag in ("h1", "h2", "h3")) == "h1" and found.tags.count("h1") == 1


def test_names_that_look_like_markup_are_text(hostile_page: str, hostile_plan: Plan) -> None:
    title = hostile_plan.scene.robot.title
    text = "".join(read(hostile_page).text)
    assert title in text
    assert "<script" not in hostile_page
    assert text.count("alert('1')") >= 2  # the description and the robot


def test_figures_are_vector_pictures_without_addresses(hostile_page: str) -> None:
    found = read(hostile_page)
    assert len(found.addresses) == 6  # tray, path, heights, contact, joints, other speeds; the tray does not tilt
    for place in found.addresses:
        svg = base64.b64decode(place.split(",", 1)[1]).decode()
        root = ElementTree.fromstring(svg)
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert "<image" not in svg and "<script" not in svg
        links = [value for item in root.iter() for name, value in item.attrib.items() if name.endswith("href")]
        assert all(link.startswith("#") for link in links)


@pytest.mark.slow
def test_same_plan_gives_the_same_page(hostile_page: str, hostile_plan: Plan) -> None:
    report = make_report(hostile_plan)
    assert html_page(report, report_svgs(report.evidence)) == hostile_page


def test_every_figure_and_row_has_its_words(hostile_page: str) -> None:
    assert hostile_page.count("<img alt='") == hostile_page.count("<img ")
    assert "<img alt=''" not in hostile_page
    assert hostile_page.count("<svg class='bar'") == hostile_page.count("of the limit'")


def test_verdict_in_words_and_sign(fast_page: str, slow_report: Report) -> None:
    good = html_page(slow_report, {})
    assert "<strong>CERTIFIED AS PUBLISHED</strong>" in good and "class='verdict yes'" in good
    assert "NOT CERTIFIED" not in good and "FAILS" not in good
    assert "<strong>NOT CERTIFIED</strong>" in fast_page and "class='verdict no'" in fast_page
    assert "<strong>CERTIFIED</strong>" not in fast_page
    signs = [re.findall(r"class='sign'.*?d=(\"[^\"]*\")|<path d=(\"[^\"]*\")", page)[0] for page in (good, fast_page)]
    assert signs[0] != signs[1]


def test_failing_rows_are_marked_once_a_constraint(fast_page: str, fast_report: Report) -> None:
    certificate = fast_report.certificate
    worst = [row for row in certificate.worst_rows() if not row.ok]
    every = [row for row in certificate.rows if not row.ok]
    assert len(worst) > 1
    bars, cells = fast_page.count(">FAILS</text>"), fast_page.count("<td>FAILS</td>")
    assert (bars, cells) == (len(worst), len(every))
    assert fast_page.count("<tr class='fails'>") == len(worst) + len(every)


def test_every_row_of_the_certificate_is_printed(fast_page: str, fast_report: Report) -> None:
    cells = read(fast_page).cells
    for row in fast_report.certificate.rows:
        at = [i for i, cell in enumerate(cells) if cell == row.constraint and cells[i + 1] == row.label]
        assert at, (row.constraint, row.label)
        assert any(row_text(row).at in cells[i : i + 8] for i in at)


@given(use=st.floats(-5.0, 50.0))
def test_bars_are_as_long_as_the_use(use: float) -> None:
    row = Row("slip", "c", "1", 1.0, use, 1.0 - use, 0.1, use <= 1.0)
    bar = _bar(row)
    (width,) = (float(found) for found in re.findall(r"<rect[^>]* width='([0-9.]+)'", bar))
    (limit,) = (float(found) for found in re.findall(r"d='M([0-9.]+) 0v13'", bar))
    assert limit == pytest.approx(100.0)
    assert width == pytest.approx(min(max(100.0 * row.use - 0.8, 0.4), 119.2), abs=0.011)
    assert ("FAILS" in bar) == (not row.ok)


@settings(max_examples=60)
@given(cells=st.lists(st.tuples(st.text(max_size=30), st.text(max_size=30)), min_size=1, max_size=5))
def test_cells_come_back_as_they_went_in(cells: list[tuple[str, str]]) -> None:
    found = read(_table(TextTable("t", ("a", "b"), tuple(cells))))
    # A parser of HTML turns every line end into one newline and NUL into nothing; we promise no more.
    wanted = [cell for row in cells for cell in row]
    assert len(found.cells) == len(wanted) + 2
    for got, cell in zip(found.cells[2:], wanted, strict=True):
        assert got.split() == cell.split() or "\0" in cell


def test_a_simulation_is_shown_or_said_to_be_missing(slow_report: Report) -> None:
    assert "NOT SIMULATED" in html_page(slow_report, {})
    moved = replace(slow_report, opinion=replace(slow_report.opinion, ok=False, message="cup moves"))
    page = html_page(moved, {})
    assert "AN OBJECT MOVES" in page and "cup moves" in page and "NOT SIMULATED" not in page


# Playwright's own loop leaves sockets to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("width", [360, 1000])
def test_a_browser_shows_it_without_a_network(browser: Any, hostile_page: str, tmp_path: Path, width: int) -> None:
    (tmp_path / "page.html").write_text(hostile_page, encoding="utf-8")
    page = browser.new_page(viewport={"width": width, "height": 800})
    asked: list[str] = []
    said: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: said.append(message.text))
    page.goto((tmp_path / "page.html").as_uri())
    sizes = page.evaluate("[...document.images].map(i => [i.complete, i.naturalWidth, i.clientWidth])")
    across = page.evaluate("document.documentElement.scrollWidth")
    page.close()
    assert [url for url in asked if not url.startswith("data:")] == [(tmp_path / "page.html").as_uri()]
    assert said == []
    assert across <= width  # nothing sticks out sideways; wide tables scroll by themselves
    assert len(sizes) == 6 and all(done and natural > 100 and shown > 300 for done, natural, shown in sizes)


def test_cells_carry_the_names_of_their_columns_for_narrow_screens() -> None:
    table = TextTable("t", ("object", "size", ""), (("cup", "70 across", "x" * 60),))
    page = _table(table)
    assert "<td data-column='size'>70 across</td>" in page
    assert f"<td class='long'>{'x' * 60}</td>" in page


def test_the_arm_and_its_tray_are_seen(slow_report: Report) -> None:
    picture = scene_picture(slow_report.evidence)
    assert picture[:3] == b"\xff\xd8\xff" and len(picture) < 200_000
    with Image.open(io.BytesIO(picture)) as image:
        assert image.size == (1520, 500)
        assert np.asarray(image.convert("L")).std() > 10  # not blank
    page = html_page(slow_report, {}, picture)
    assert "data:image/jpeg;base64," in page
    read(page)
    assert "data:image/jpeg" not in html_page(slow_report, {})


@pytest.mark.parametrize("published", [True, False])
def test_only_a_plan_by_the_published_equations_is_said_to_be_judged_by_them(
    slow_report: Report, published: bool
) -> None:
    beyond = tuple(row for row in slow_report.certificate.rows if row.constraint == "slip")[:1]
    said = _beyond(replace(slow_report.certificate, full_model=beyond, published=published))
    assert said.endswith(".") and (" Judged by the published equations; the full model sees" in said) == published
    assert _beyond(replace(slow_report.certificate, full_model=())) == ""
