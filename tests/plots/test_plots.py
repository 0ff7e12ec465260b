"""Figures: the files, what is on them, and that they leave nothing behind."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image
from scipy.integrate import solve_ivp

from nospill.certification.limiting import limiting_names
from nospill.certification.verdict import Trace
from nospill.certification.wording import integrity_line, row_text, shown_unit
from nospill.core.units import superscript
from nospill.errors import PlanFolderError
from nospill.laws.constraints import CONSTRAINTS, constrained
from nospill.laws.constraints.base import EvaluationPoint
from nospill.plots import figures, save_figures
from nospill.plots.evidence import AFTER_END, Evidence
from nospill.plots.joints import _quietest
from nospill.plots.style import BLUE, LOOK, RED, plain, series_look
from nospill.scenario import scene_from_table
from nospill.scene.sloshing.modes import WALL_POINTS
from tests.plots.small_plans import CARGO, LONG, cup, plan_of, table
from tests.waiting import run_python

APPLYING = {"slosh-heights", "margins", "joints", "tilt", "other-speeds", "summary"}
"""Figures of every plan that tilts with liquids and has no obstacles; limits where it comes near any."""


EIGHT = [
    cup(name, -112 + 75 * (index % 4), -60 + 120 * (index // 4))
    for index, name in enumerate(["_a", LONG, "c", LONG[::-1], "e", "f", "g", "h"])
]


@pytest.fixture(scope="module")
def tilting() -> Evidence:
    return Evidence(*plan_of(scene_from_table(table(CARGO, tilt="free"), name="x"), 1.0))


@pytest.fixture(scope="module")
def crowded() -> Evidence:
    """Eight cups with awkward names, driven far too fast."""
    scene = scene_from_table(table(EIGHT) | {"fidelity": "deliverable", "name": LONG}, name="x")
    found = Evidence(*plan_of(scene, 0.4))
    assert not found.judgement.certificate.ok
    return found


def drawn(evidence: Evidence, *names: str) -> dict[str, Figure]:
    """The figures of these names, all when there are none."""
    with matplotlib.rc_context(LOOK):
        pictures = {name: draw(evidence) for name, draw in figures.FIGURES.items() if name in names or not names}
        found = {name: figure for name, figure in pictures.items() if figure is not None}
        for figure in found.values():
            FigureCanvasAgg(figure).draw()
    return found


@pytest.fixture(scope="module")
def pictures(tilting: Evidence) -> dict[str, Figure]:
    return drawn(tilting)


@pytest.fixture(scope="module")
def crowded_pictures(crowded: Evidence) -> dict[str, Figure]:
    return drawn(crowded)


def texts(figure: Figure) -> list[str]:
    return [item.get_text() for item in figure.findobj(Text) if isinstance(item, Text)]


def panels(figure: Figure) -> Iterator[Axes]:
    yield from (axes for axes in figure.axes if axes.axison and axes.name == "rectilinear")


def series(axes: Axes) -> list:
    """The lines that are data: more than the two points of a limit."""
    return [line for line in axes.lines if len(np.asarray(line.get_xdata())) > 2]


@pytest.mark.slow
def test_files_are_written_and_readable(tilting: Evidence, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    monkeypatch.setattr("nospill.plans.plan.judge", lambda *given: calls.append(given) or tilting.judgement)
    before = dict(matplotlib.rcParams)
    pyplot = "matplotlib.pyplot" in sys.modules
    (tmp_path / "deep" / "figures").mkdir(parents=True)
    (tmp_path / "deep" / "figures" / "mine.txt").write_text("kept")
    written = save_figures(dataclasses.replace(tilting.plan), tmp_path / "deep" / "figures", pdf=True)
    assert calls == [(tilting.plan.trajectory, tilting.plan.scene)]
    applying = [name for name in figures.FIGURES if name in {*APPLYING, *(["limits"] if tilting.limiting else [])}]
    assert [path.name for path in written] == [f"{name}.{end}" for name in applying for end in ("png", "pdf")]
    assert {path.name for path in written} | {"mine.txt"} == {p.name for p in (tmp_path / "deep" / "figures").iterdir()}
    for path in written:
        assert 10_000 < path.stat().st_size < 800_000
        if path.suffix == ".png":
            with Image.open(path) as image:
                image.load()
                dots = figures.SHEET_RESOLUTION if path.stem == "summary" else figures.RESOLUTION
                assert image.info["dpi"] == pytest.approx((dots, dots), abs=0.1)
                assert min(image.size) > 500
                assert np.asarray(image.convert("L")).std() > 20  # not blank
        else:
            data = path.read_bytes()
            assert data.startswith(b"%PDF-1.")
            assert data.rstrip().endswith(b"%%EOF")
            assert b"/Subtype /Image" not in data  # vector throughout
            assert b"CreationDate" not in data
    assert dict(matplotlib.rcParams) == before
    assert ("matplotlib.pyplot" in sys.modules) == pyplot


def test_folder_that_cannot_be_made(tilting: Evidence, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nospill.plans.plan.judge", lambda *_: tilting.judgement)
    (tmp_path / "taken").write_text("")
    with pytest.raises(PlanFolderError, match="figures cannot be written"):
        save_figures(tilting.plan, tmp_path / "taken")


def test_importing_the_package_draws_in_nothing() -> None:
    code = "import sys, nospill.plots; print([m for m in ('matplotlib', 'casadi') if m in sys.modules])"
    run = run_python("-c", code, check=True)
    assert run.stdout.strip() == "[]"


def test_no_pyplot_anywhere() -> None:
    for path in Path(figures.__file__).parent.glob("*.py"):
        assert "pyplot" not in path.read_text()


def test_which_figures_apply(pictures: dict[str, Figure], crowded_pictures: dict[str, Figure]) -> None:
    assert set(pictures) | {"limits"} == APPLYING | {"limits"} == set(figures.FIGURES) - {"distances", "swept-volume"}
    assert set(crowded_pictures) == (APPLYING | {"limits"}) - {"tilt"}


def test_solid_cargo_has_no_slosh_figure(tilting: Evidence) -> None:
    traces = tuple(trace for trace in tilting.judgement.traces if trace.constraint != "slosh height")
    judgement = dataclasses.replace(tilting.judgement, traces=traces)
    assert figures.FIGURES["slosh-heights"](Evidence(tilting.plan, judgement)) is None


@pytest.mark.parametrize("name", ["slosh-heights", "margins", "joints", "tilt", "summary"])
def test_axes_carry_units(pictures: dict[str, Figure], name: str) -> None:
    bottom = [axes.get_xlabel() for axes in panels(pictures[name])]
    assert "time [s]" in bottom
    for axes in panels(pictures[name]):
        if "at no limit" in [item.get_text() for item in axes.get_yticklabels()]:
            continue  # its rows are named, not numbered
        label = axes.get_ylabel()
        shared = label == "" and name == "slosh-heights"
        assert shared or (label.endswith("]") and "[" in label), label


def test_limits_are_drawn_and_named(pictures: dict[str, Figure]) -> None:
    heights = list(panels(pictures["slosh-heights"]))
    assert [axes.get_title(loc="left") for axes in heights] == ["cup", "box"]
    for axes, limit, rest in zip(heights, ("13.6", "20"), ("2.72", "4"), strict=True):  # 22 mm are stated: waves break
        named = [item.get_text() for item in axes.texts]
        assert f"limit {limit} mm" in named
        assert f"{rest} mm" in named
        assert "end of motion" in named
        red = [line for line in axes.lines if line.get_color() == RED]
        assert [float(np.asarray(line.get_ydata())[0]) for line in red] == pytest.approx(
            [float(limit), float(rest)], rel=0.01
        )
    for axes in panels(pictures["margins"]):
        assert "limit 1" in [item.get_text() for item in axes.texts]
        assert [np.asarray(x.get_ydata())[0] for x in axes.lines if x.get_color() == RED] == [1.0]
    assert {"limit 1", "limit −1"} <= set(texts(pictures["joints"]))
    assert any(text.startswith("limit of each angle") for text in texts(pictures["tilt"]))


def test_one_panel_per_constraint_one_line_per_object(tilting: Evidence, pictures: dict[str, Figure]) -> None:
    shown = [c for c in CONSTRAINTS if c.evaluated_at is EvaluationPoint.OBJECT and c.subjects(tilting.plan.scene)]
    peaks = {
        c.name: max(float(np.max(trace.use)) for trace in tilting.traces(c.name))
        for c in shown
        if c.name != "slosh height"
    }
    names = sorted((name for name in peaks if peaks[name] >= 0.1), key=lambda name: -peaks[name])
    assert [axes.get_title(loc="left") for axes in panels(pictures["margins"])] == names
    slack = [name for name in peaks if name not in names]
    assert all(any(name in text for text in texts(pictures["margins"])) for name in slack)
    for axes in panels(pictures["margins"]):
        name = axes.get_title(loc="left")
        assert len(series(axes)) == sum(trace.constraint == name for trace in tilting.judgement.traces) > 0


@pytest.mark.slow
def test_new_constraint_gets_its_panel_bar_and_legend(tilting: Evidence) -> None:
    """A constraint that plots has never heard of, which may be missing for some objects."""
    known = next(constraint for constraint in CONSTRAINTS if constraint.name == "tip")
    splash = type("Splash", (type(known),), {"name": "splash", "unit": "m/s"})()
    t = tilting.judgement.replay.t
    value = np.linspace(0.0, 0.7, len(t))
    extra = Trace("splash", "box", "m/s", t, value, np.full(len(t), 0.5), 0.5 - value)
    scene = constrained(tilting.plan.scene, [splash])
    judgement = dataclasses.replace(tilting.judgement, traces=(*tilting.judgement.traces, extra))
    figure = drawn(Evidence(dataclasses.replace(tilting.plan, scene=scene), judgement), "margins")["margins"]
    axes = next(axes for axes in panels(figure) if axes.get_title(loc="left") == "splash")
    shown = [axes.get_title(loc="right"), *(item.get_text() for item in axes.texts)]
    assert "max 140.0 % (box)" in shown
    assert np.asarray(series(axes)[0].get_ydata())[-1] == pytest.approx(1.4)


@pytest.mark.parametrize("which", ["pictures", "crowded_pictures"])
def test_nothing_is_clipped(which: str, request: pytest.FixtureRequest) -> None:
    for name, figure in request.getfixturevalue(which).items():
        used = figure.get_tightbbox()  # in of everything that is drawn, letters included
        width, height = figure.get_size_inches()
        assert used.x0 >= 0, name
        assert used.y0 >= 0, name
        assert used.x1 <= width + 0.01, name
        assert used.y1 <= height + 0.01, name


def test_long_titles_do_not_meet(crowded_pictures: dict[str, Figure]) -> None:
    for name, figure in crowded_pictures.items():
        for axes in panels(figure):
            left, right = axes._left_title, axes._right_title  # type: ignore[attr-defined]
            if left.get_text() and right.get_text():
                assert left.get_window_extent().x1 < right.get_window_extent().x0, name
        if name != "summary":
            title, verdict = figure.texts[:2]
            assert verdict.get_window_extent().y1 < title.get_window_extent().y0
            assert max(item.get_window_extent().x1 for item in (title, verdict)) < figure.bbox.x1


def test_legends_name_every_object(crowded_pictures: dict[str, Figure]) -> None:
    legend = crowded_pictures["margins"].legends[0]
    assert [text.get_text().lstrip("\u200b") for text in legend.get_texts()] == [plain(str(c["name"])) for c in EIGHT]


def test_lines_differ_without_colour() -> None:
    """Twenty lines in a row have their own pair of dash pattern and marker, so grey paper keeps them apart."""
    looks = [series_look(index) for index in range(20)]
    assert len({(str(look["linestyle"]), look.get("marker", "")) for look in looks}) == 20
    assert len({look["color"] for look in looks[:7]}) == 7


def test_data_lines_of_a_panel_differ(crowded_pictures: dict[str, Figure]) -> None:
    for name in ("margins", "joints"):
        for axes in panels(crowded_pictures[name]):
            styles = [(str(line._unscaled_dash_pattern), line.get_marker()) for line in series(axes)]
            assert len(set(styles)) == len(styles) >= 6


def test_free_heights_against_integration(tilting: Evidence) -> None:
    """An adaptive integration of the linear oscillators, and the heights written out by hand."""
    played, scene = tilting.judgement.replay, tilting.plan.scene
    t, heights = tilting.free_heights()
    assert t[0] == played.t[-1]
    assert t[-1] - t[0] == pytest.approx(AFTER_END)
    start = 0
    for cargo in scene.cargo:
        if cargo.filling is None:
            continue
        eta, yaw = np.zeros((2, len(t))), np.zeros((WALL_POINTS, len(t)))
        for mode in cargo.filling.oscillators:
            for direction in mode.directions:

                def rate(_: float, x: np.ndarray, w: float = mode.frequency, z: float = mode.damping) -> list[float]:
                    return [x[1], -2 * z * w * x[1] - w * w * x[0]]

                state = [played.slosh_displacement[-1, start], played.slosh_velocity[-1, start]]
                swing = solve_ivp(rate, (t[0], t[-1]), state, t_eval=t, rtol=1e-9, atol=1e-12).y[0]
                if mode.yaws:
                    yaw += np.outer(mode.wall_gains, swing)
                else:
                    eta["xy".index(direction)] += mode.surface_gain * swing
                start += 1
        wanted = np.hypot(*eta) if cargo.shape == "cylinder" else np.abs(eta).sum(axis=0)
        wanted += np.max(np.abs(yaw), axis=0)
        assert np.max(np.abs(heights[cargo.name] - wanted)) < 1e-8
        assert np.max(wanted) > 1e-5


def test_free_heights_go_on_where_the_motion_ends(crowded: Evidence) -> None:
    _, heights = crowded.free_heights()
    assert list(heights) == [cargo["name"] for cargo in EIGHT]
    bounds = {trace.subject: float(trace.value[0]) for trace in crowded.traces("residual height")}
    for trace in crowded.traces("slosh height"):
        free = heights[trace.subject]
        assert free[0] == pytest.approx(trace.value[-1], abs=1e-9)
        # The record ends up to one sample after the motion; the paraboloid of 28 mm changes the swing in it.
        assert 0.5 * bounds[trace.subject] < np.max(free) <= 1.005 * bounds[trace.subject] + 1e-6


@pytest.mark.slow
def test_summary_says_what_counts(tilting: Evidence, crowded: Evidence, crowded_pictures: dict[str, Figure]) -> None:
    good, bad = texts(drawn(tilting)["summary"]), texts(crowded_pictures["summary"])
    assert f"{tilting.end_time:.3f} s" in good
    assert f"{tilting.maxima.tray_acceleration:.3g} m/s²" in good
    largest = max(float(np.max(np.abs(trace.value))) for trace in tilting.traces("tilt"))
    assert f"{np.degrees(largest):.3g}°" in good
    assert tilting.limiting_text in good or tilting.limiting_text == ""
    certificate = crowded.judgement.certificate
    for row in certificate.listed_rows():
        assert row.constraint in bad
        assert row_text(row).use in bad
    assert integrity_line(certificate) in bad
    broken = {row.constraint for row in certificate.rows if not row.ok}
    assert bad.count("FAILS") == len(broken) > 0
    assert any(text.startswith("NOT CERTIFIED") for text in bad)


def test_limits_over_time_are_named_with_their_shares(crowded: Evidence, crowded_pictures: dict[str, Figure]) -> None:
    figure = crowded_pictures["limits"]
    axes = next(axes for axes in figure.axes if axes.get_yticklabels())
    names = [item.get_text() for item in axes.get_yticklabels()]
    shown = crowded.limiting[: len(names) - 1]
    wanted = limiting_names([item.row for item in shown], crowded.plan.scene.robot.joints)
    assert names[-1] == "at no limit"
    for name, whole in zip(names, wanted, strict=False):  # a long one takes two lines
        assert max(map(len, name.split("\n"))) <= 24
        assert "".join(name.split()) == plain("".join(whole.split()), 44) or len(whole) > 40
    shares = [item.get_text() for item in axes.texts if item.get_text().endswith(" %")]
    assert shares[:-1] == [f"{100 * item.share:.0f} %" for item in shown]
    assert shown[0].share > 0.2
    assert axes.get_xlim() == (0.0, crowded.end_time)


def test_nearest_row_of_every_constraint(crowded: Evidence) -> None:
    certificate = crowded.judgement.certificate
    worst = {row.constraint: row for row in certificate.worst_rows()}
    checks = {row.constraint for row in certificate.record_rows()}
    assert set(worst) | checks == {row.constraint for row in certificate.rows}
    assert not set(worst) & checks and "path covered" in checks
    listed = {row.constraint: row for row in certificate.listed_rows()}
    assert all(not listed[row.constraint].ok for row in certificate.rows if not row.ok)
    order = [(row.ok, -row.use) for row in certificate.worst_rows()]
    assert order == sorted(order)


def test_units_as_printed() -> None:
    assert superscript(shown_unit("rad/s^3")[1]) == "rad/s³"
    assert superscript("m/s^2") == "m/s²"


@pytest.mark.slow
def test_a_judgement_at_hand_is_shown_and_not_made_again(
    tilting: Evidence, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("judged again")

    monkeypatch.setattr("nospill.plans.plan.judge", never)
    monkeypatch.setattr(figures, "FIGURES", {"joints": figures.FIGURES["joints"]})
    plan = dataclasses.replace(tilting.plan, judgement=tilting.judgement)
    told: list[tuple[int, int]] = []
    written = save_figures(plan, tmp_path, progress=lambda *done: told.append(done))
    assert [path.name for path in written] == ["joints.png"]
    assert told == [(0, 1)]
    assert [path.name for path in save_figures(plan, tmp_path, pdf=True)] == ["joints.png", "joints.pdf"]
    assert save_figures(plan, tmp_path, names=["summary"]) == []
    assert plan == plan and "judgement" not in repr(plan)


def test_names_are_no_formulas() -> None:
    assert plain("a$b$c") == r"a\$b\$c"
    assert plain("x" * 22) == "x" * 22
    assert len(plain(LONG)) == 22
    assert plain(LONG, 10)[:6] == LONG[:6]
    assert plain(LONG, 10)[-3:] == LONG[-3:]


def test_slosh_curve_is_the_judges(tilting: Evidence, pictures: dict[str, Figure]) -> None:
    trace = tilting.traces("slosh height")[0]
    line = next(line for line in next(panels(pictures["slosh-heights"])).lines if line.get_color() == BLUE)
    assert np.array_equal(np.asarray(line.get_ydata()), 1e3 * trace.value)
    assert np.array_equal(np.asarray(line.get_xdata()), trace.t)


def test_long_names_of_constraints_leave_their_peak_inside_the_panel(pictures: dict[str, Figure]) -> None:
    """The column is too narrow for "apparent gravity" beside its largest figure; nothing may be printed over it."""
    axes = next(axes for axes in panels(pictures["margins"]) if axes.get_title(loc="left") == "apparent gravity")
    assert axes.get_title(loc="right") == ""
    peak = next(item for item in axes.texts if item.get_text().startswith("max "))
    inside, box = peak.get_window_extent(), axes.get_window_extent()
    assert box.x0 < inside.x0 and inside.x1 < box.x1 and inside.y1 < box.y1


def with_further_limits(evidence: Evidence) -> Evidence:
    """The same motion of an arm of whose accelerations, jerks and torques limits are known; traces are made up."""
    played, joints = evidence.judgement.replay, evidence.plan.scene.robot.joints
    made = []
    for name, unit, limit in (("joint acceleration", "rad/s^2", 10.0), ("joint torque", "N m", 80.0)):
        for index, joint in enumerate(joints):
            value = limit * np.sin(played.t * (1 + index)) * 0.9
            made.append(Trace(name, joint, unit, played.t, value, np.full(len(value), limit), limit - np.abs(value)))
    kept = [trace for trace in evidence.judgement.traces if trace.constraint != "joint acceleration"]
    return Evidence(evidence.plan, dataclasses.replace(evidence.judgement, traces=(*kept, *made)))


def test_every_limit_of_the_joints_has_its_panel(tilting: Evidence, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures, "FIGURES", {"joints": figures.FIGURES["joints"]})
    figure = drawn(with_further_limits(tilting))["joints"]
    titles = [axes.get_title(loc="left") for axes in panels(figure)]
    assert titles[1:] == ["joint speed", "joint acceleration", "joint torque"]
    for axes in list(panels(figure))[1:]:
        assert {"limit 1", "limit −1"} <= {item.get_text() for item in axes.texts}
        assert len(series(axes)) == len(tilting.plan.scene.robot.joints)
    (torque,) = (axes for axes in panels(figure) if axes.get_title(loc="left") == "joint torque")
    assert max(float(np.max(np.abs(line.get_ydata()))) for line in series(torque)) == pytest.approx(0.9, abs=1e-3)
    assert figure.get_tightbbox().x1 <= figure.get_size_inches()[0] + 0.01


def test_names_of_position_limits_keep_apart() -> None:
    """Every corner that is given lies at its limit, and no two names lie on each other while there is room."""
    t, y = np.linspace(0, 1, 200), np.full(200, 0.5)
    taken: list[tuple[float, float]] = []
    for at in (0.5, 0.5, 0.75, 0.9):
        left, bottom = _quietest(t, y, at, True, taken)
        assert bottom in (at, at - 0.1) and 0.0 <= left <= 0.64
        assert all(abs(left - x) >= 0.36 or abs(bottom - z) >= 0.1 for x, z in taken)
        taken.append((left, bottom))


@pytest.mark.parametrize("name", ["margins", "joints", "slosh-heights", "tilt"])
def test_letters_stay_readable_in_a_column(pictures: dict[str, Figure], name: str) -> None:
    """Printed 85 mm wide no letter is below 5.5 points."""
    figure = pictures[name]
    scale = 85 / 25.4 / figure.get_size_inches()[0]
    shown = [item for item in figure.findobj(Text) if isinstance(item, Text) and item.get_text() and item.get_visible()]
    assert min(float(item.get_fontsize()) for item in shown) * scale > 5.5
