"""What a report says, against closed forms and the plan's own figures; and its sheets of paper."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from nospill.plans.loading import load_plan
from nospill.plans.names import TRAJECTORY_FILE
from nospill.plans.plan import Plan
from nospill.plots.figures import REPORT_FIGURES
from nospill.plots.report_pages import report_pdf
from nospill.plots.sheets import PAPER
from nospill.plots.style import LOOK
from nospill.plots.text_pages import FigureRow, TextTable, printable, text_pages
from nospill.plots.tray_plan import footprint_outline
from nospill.report import Report, make_report
from nospill.report.contents import certificate_table
from nospill.report.page import html_page
from nospill.report.task import task_table
from nospill.report.writing import pdf_tables
from nospill.scenario import scene_from_table


def facts(table: TextTable) -> dict[str, str]:
    return {row[0]: row[1] for row in table.rows}


def test_a_straight_line_is_described_by_its_own_figures(slow_plan: Plan) -> None:
    line = {"type": "line", "start": ["0.3 m", "-0.2 m", "1 m"], "end": ["0.3 m", "0.2 m", "1.3 m"]}
    source = dict(slow_plan.scene.source) | {"path": line | {"yaw": ["10 deg", "50 deg"]}}
    stated = facts(task_table(scene_from_table(source, name="x")))
    assert stated["path"] == (
        "line, 0.50 m long, from (0.300, −0.200, 1.000) m to (0.300, 0.200, 1.300) m of the base, yaw from 10 to 50 deg"
    )
    assert stated["tray"] == "335 x 250 mm, surface at (0, 0, 108) mm of the flange"
    assert stated["attitude"] == "the tray stays level"


def test_motion_rules_and_given_limits_are_stated(slow_plan: Plan) -> None:
    source = dict(slow_plan.scene.source)
    source |= {"motion": {"tilt": "free", "max_tilt": "20 deg", "end": "still", "residual_fraction": 0.1}}
    source |= {"robot": {"model": "comau-smart-six", "limits": {"speed_scale": 0.5}, "limits_applied": "all"}}
    stated = facts(task_table(scene_from_table(source, name="x")))
    assert "up to 20 deg" in stated["attitude"]
    assert "stand still" in stated["at the end"] and "10 %" in stated["at the end"]
    assert stated["limit of speed scale"] == "0.5"
    assert stated["robot, limits applied"] == "all"


def test_figures_of_the_motion(slow_report: Report, slow_plan: Plan) -> None:
    tiles = {tile.label: tile.value for tile in slow_report.tiles}
    assert tiles["duration"] == f"{slow_plan.duration:.3f} s"
    acceleration = np.max(np.linalg.norm(slow_report.evidence.judgement.replay.tray.acceleration, axis=1))
    assert tiles["largest tray acceleration"] == f"{acceleration:.3g} m/s²"
    height = next(row for row in slow_report.certificate.rows if row.constraint == "slosh height")
    assert tiles["cup rises, 12 mm allowed"] == f"{1e3 * height.worst_value:.3g} mm"
    assert tiles["left to the rim of cup"] == f"{np.floor(1e4 * (0.099 - 0.049 - height.worst_value)) / 10:.1f} mm"
    assert int(tiles["moves an hour, one way"].replace("\u202f", "")) == int(3600 / slow_plan.duration)


def test_figures_turn_red_where_their_limit_fails(slow_report: Report, fast_report: Report) -> None:
    assert all(tile.ok for tile in slow_report.tiles)
    failed = {row.constraint for row in fast_report.certificate.rows if not row.ok}
    assert {tile.ok for tile in fast_report.tiles} == {True, False}
    for tile in fast_report.tiles:
        assert tile.ok or "reserve" in tile.label or "slosh height" in failed or "joint speed" in failed
    page = html_page(fast_report, {})
    assert page.count("<li class='fails'>") == sum(not tile.ok for tile in fast_report.tiles)


@pytest.mark.slow
def test_warnings_are_those_of_the_judged_motion(slow_report: Report, slow_plan: Plan) -> None:
    assert slow_report.warnings.rows == (("none", "", ""),)
    tightened = replace(slow_plan, report=replace(slow_plan.report, backoff={"slip | cup": 0.2}))
    (row,) = make_report(tightened).warnings.rows
    assert row[:2] == ("back-off", "slip | cup")
    assert any(slow_report.warnings in tables for tables in pdf_tables(slow_report))


def test_joints_used_of_their_limits(slow_report: Report, slow_plan: Plan) -> None:
    rows = slow_report.joints.rows
    assert [row[0] for row in rows] == list(slow_plan.scene.robot.joints)
    speed = slow_report.joints.columns.index("speed [deg/s]")
    played = np.degrees(np.max(np.abs(slow_report.evidence.judgement.replay.joint_speed), axis=0))
    limits = np.degrees(slow_plan.scene.robot.max_speed)
    for row, value, limit in zip(rows, played, limits, strict=True):
        stated = re.fullmatch(r"(?:< )?(\S+) of (\S+) \(([0-9.]+) %\)", row[speed])
        assert stated is not None
        assert float(stated[1]) == pytest.approx(value, rel=6e-3, abs=2e-3 * limit)
        assert float(stated[2]) == pytest.approx(limit, rel=1e-3)
        assert float(stated[3]) == pytest.approx(np.floor(1e3 * value / limit) / 10, abs=1e-9)


def test_the_verdict_is_that_of_the_samples_not_of_the_file(fast_plan: Plan, slow_plan: Plan) -> None:
    """A certificate from elsewhere does not make a report certified."""
    forged = replace(fast_plan, certificate=slow_plan.certificate, judgement=None)
    report = make_report(forged)
    assert not report.ok and report.verdict == "not certified"
    failed = sum(not row.ok for row in fast_plan.certificate.rows)
    assert report.detail.startswith(f"{failed} of {len(fast_plan.certificate.rows)} rows fail")


@pytest.mark.slow
def test_checksum_is_that_of_the_file(folder: Path, slow_report: Report) -> None:
    digest = hashlib.sha256((folder / TRAJECTORY_FILE).read_bytes()).hexdigest()
    for report in (slow_report, make_report(load_plan(folder))):
        stated = facts(report.versions)["trajectory.csv"]
        assert f"{digest[:16]}…{digest[-8:]}" in stated


@pytest.mark.slow
def test_controller_files_that_differ_are_marked(slow_plan: Plan) -> None:
    report = make_report(slow_plan, controller_files={"robot.csv": "moves otherwise"})
    (index,) = report.versions.failing
    assert report.versions.rows[index] == ("robot.csv", "moves otherwise")


def test_certificate_table_has_every_row(fast_report: Report) -> None:
    certificate = fast_report.certificate
    table = certificate_table(certificate, everything=True)
    assert [row[:2] for row in table.rows] == [(row.constraint, row.label) for row in certificate.rows]
    assert table.failing == tuple(i for i, row in enumerate(certificate.rows) if not row.ok)


def test_footprints_on_the_tray_are_to_scale(slow_plan: Plan) -> None:
    cup, block = (footprint_outline(item) for item in slow_plan.scene.cargo)
    assert np.hypot(*(cup - [-0.1, -0.06]).T) == pytest.approx(0.025)
    corners = np.array([[40, 20], [-40, 20], [-40, -20], [40, -20]]) * 1e-3
    turn = np.array([[np.cos(np.pi / 6), -np.sin(np.pi / 6)], [np.sin(np.pi / 6), np.cos(np.pi / 6)]])
    wanted = [0.07, 0.04] + corners @ turn.T
    assert np.allclose(sorted(map(tuple, block)), sorted(map(tuple, wanted)))


@pytest.mark.parametrize("name", ["tray", "path"])
def test_nothing_is_clipped_in_the_report_s_own_figures(slow_report: Report, name: str) -> None:
    with matplotlib.rc_context(LOOK):
        figure = REPORT_FIGURES[name](slow_report.evidence)
        assert figure is not None
        FigureCanvasAgg(figure).draw()
    used = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    letters = [item.get_fontsize() for item in figure.findobj(Text) if item.get_text() and item.get_visible()]
    assert min(letters) * 85 / 25.4 / width > 5.5  # points, printed 85 mm wide  # pyright: ignore[reportOperatorIssue]
    assert used.x0 >= 0 and used.y0 >= 0 and used.x1 <= width + 0.01 and used.y1 <= height + 0.01


# --- paper ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_pdf_has_every_page_and_no_picture(slow_report: Report) -> None:
    first, last = pdf_tables(slow_report)
    data = report_pdf(slow_report.evidence, first, last, "footer")
    assert data.startswith(b"%PDF-1.") and data.rstrip().endswith(b"%%EOF")
    assert 3 <= len(re.findall(rb"/Type /Page\b", data)) <= 5
    assert b"/Subtype /Image" not in data and b"CreationDate" not in data
    assert b"/Subtype /Type3" not in data and b"/FontFile2" in data  # letters as TrueType
    assert data == report_pdf(slow_report.evidence, first, last, "footer")
    boxes = {tuple(float(x) for x in box.split()) for box in re.findall(rb"/MediaBox \[ ?([^\]]+)\]", data)}
    points = {tuple(sorted(round(side) for side in box[2:])) for box in boxes}
    assert points <= {(595, 842), (595, 843), (596, 842)}
    assert all(box[2] < box[3] for box in boxes)  # upright


@settings(max_examples=25, deadline=None)
@given(
    rows=st.lists(
        st.tuples(st.text("abc $x", max_size=20), st.text("abcdef gh", max_size=300)), min_size=0, max_size=120
    )
)
def test_no_word_is_lost_between_sheets(rows: list[tuple[str, str]]) -> None:
    table = TextTable("many words", ("who", "what"), tuple(rows), note="the end")
    pages = [sheet.page for sheet in text_pages((table, table), "heading")]
    stated = [text.get_text().replace(r"\$", "$") for page in pages for text in page.texts]
    for words in (rows, [("many words", ""), ("the end", "")]):
        found = "".join("".join(stated).split())
        for row in words:
            for cell in row:
                for word in printable(cell).split():
                    assert word in found
    for page in pages:
        for text in page.texts:
            x, y = text.get_position()
            assert 0.0 < x < 1.0 and 0.5 / PAPER[1] < y < 1.0


def test_figures_stay_on_their_sheet_and_apart_from_words(slow_report: Report) -> None:
    first, _ = pdf_tables(slow_report)
    with matplotlib.rc_context(LOOK):
        figures = [Figure(figsize=(4.4, height)) for height in (3.0, 5.0, 6.0, 2.0)]
        rows = (FigureRow((figures[0], figures[1])), FigureRow((figures[2],), "a title"), FigureRow((figures[3],)))
        sheets = text_pages((rows[0], *first, *rows[1:]), "heading")
    assert [item.figure for sheet in sheets for item in sheet.placed] == figures
    for number, sheet in enumerate(sheets, 1):
        assert f"page {number} of {len(sheets)}" in [text.get_text() for text in sheet.page.texts]
        lines = [PAPER[1] * (1 - text.get_position()[1]) for text in sheet.page.texts]
        for item in sheet.placed:
            width, height = item.scale * item.figure.get_size_inches()
            assert item.left >= 0.5 and item.left + width <= PAPER[0] - 0.5
            assert item.top >= 0.5 and item.top + height <= PAPER[1] - 0.5
            assert not any(item.top < y < item.top + height for y in lines)


def test_a_table_over_two_sheets_names_its_columns_again() -> None:
    table = TextTable("long", ("who", "what"), tuple((str(number), "x") for number in range(150)))
    sheets = text_pages((table,), "footer")
    assert len(sheets) == 2
    for sheet in sheets:
        assert {"who", "what"} <= {text.get_text() for text in sheet.page.texts}


def test_letters_that_the_font_lacks_are_boxes() -> None:
    assert printable("a\u6c34b\n c$") == "a\u25a1b c$"
    assert printable("θ² − ≤ é") == "θ² − ≤ é"


def test_what_is_wide_is_wrapped_inside_the_sheet(slow_report: Report) -> None:
    with matplotlib.rc_context(LOOK):
        first, last = pdf_tables(slow_report)
        for page in [sheet.page for sheet in text_pages((*first, *last), "heading")]:
            FigureCanvasAgg(page).draw()
            for text in page.texts:
                assert text.get_window_extent().x1 <= page.bbox.x1, text.get_text()
