"""What was executed, judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import judge
from nospill.certification.clearance import NEAR, OTHERS
from nospill.certification.happening import happening_line, tray_first
from nospill.certification.tracked_rows import without_reserve
from nospill.certification.verdict import Row, Trace, limit_trace
from nospill.errors import ScenarioError
from nospill.execution.bands import CERTIFIED, NOT_CERTIFIED, OPEN, WIDE, height_bands, outcome, row_bands
from nospill.execution.executed import Executed, executed
from nospill.execution.motion import recorded_motion
from nospill.execution.reading import read_log
from nospill.execution.record import executed_table, failing, log_lines, tracking_lines, undecided, verdict
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.simulation.motion_file import Heights, read_heights
from tests.execution.logs import log_of
from tests.measured import measured_data

CLOCK = 0.5


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


@pytest.fixture(scope="module")
def found(plan: Plan) -> Executed:
    return executed(log_of(plan, clock=CLOCK), plan.scene, plan=plan)


@pytest.mark.slow
def test_a_motion_that_was_executed_as_planned_is_certified_as_planned(found: Executed) -> None:
    assert found.outcome != NOT_CERTIFIED
    assert found.planned is not None
    planned = {(row.constraint, row.subject): row for row in found.planned.certificate.rows}
    for row in found.judgement.certificate.rows:
        band = found.bands[RowId(row.constraint, row.subject)]
        if row.constraint not in ("still at the end", "residual height"):  # the end is known within milliseconds
            off = 2.0 * band + 2e-3 * abs(row.limit) + 1e-4
            require_agreement(row, planned[row.constraint, row.subject], off)


def require_agreement(row: Row, planned: Row, off: float) -> None:
    """Two margins differ by no more than `off`, in their unit.

    A distance is a bound, at most a tenth below the true margin; of pairs beyond `NEAR` it is any bound beyond it.
    """
    if row.constraint == Clearance.name:
        assert (row.worst_value >= NEAR) == (planned.worst_value >= NEAR) == (row.subject == OTHERS)
        off = np.inf if row.subject == OTHERS else off + 0.11 * planned.worst_margin
    assert row.worst_margin == pytest.approx(planned.worst_margin, abs=off), row.id


def test_the_clock_of_the_log_is_found(found: Executed) -> None:
    assert found.clock == pytest.approx(CLOCK, abs=5e-5)
    assert found.recorded.sampling.even
    assert found.recorded.smooth.noise == pytest.approx(np.full(6, 1e-6), rel=0.3)


def test_begin_and_end_are_found_under_noise(plan: Plan, found: Executed) -> None:
    loud = recorded_motion(log_of(plan, noise=2e-5), plan.scene)
    assert loud.begin == pytest.approx(found.recorded.begin, abs=0.05)
    assert loud.end == pytest.approx(found.recorded.end, abs=0.05)
    assert loud.begin == pytest.approx(CLOCK, abs=0.1)


@pytest.mark.parametrize("rate", [125.0, 500.0])
def test_a_log_that_begins_with_the_motion_is_not_led_up_to(plan: Plan, rate: float) -> None:
    """Without noise, from the first sample of the motion to its last: the arm stood before, and stands on."""
    log = log_of(plan, clock=0.0, noise=0.0, jitter=0.0, rate=rate)
    rows = np.arange(int(np.ceil(plan.duration * rate)) + 1)
    found = recorded_motion(replace(log, t=log.t[rows], position=log.position[rows]), plan.scene)
    t = np.linspace(-0.04, plan.duration + 0.04, 2000)
    off = found.held()(t) - plan.trajectory.motion(t)
    assert found.is_exact
    assert np.abs(off).max() < 1e-5 * (125.0 / rate) ** 3


def test_heights_are_those_of_the_plan(found: Executed) -> None:
    assert found.planned is not None
    for trace in found.planned.traces:
        if trace.constraint == SloshHeight.name:
            again = np.interp(trace.t, found.judgement.replay.t, found.heights[trace.subject])
            assert np.max(np.abs(again - trace.value)) < 3e-5


def test_a_late_joint_is_told_and_what_it_adds(plan: Plan) -> None:
    late = np.array([0.0, 0.0, 0.004, 0.0, 0.0, 0.0])
    found = executed(log_of(plan, delays=late), plan.scene, plan=plan)
    assert found.tracking is not None
    told = np.isfinite(found.tracking.delay)
    assert found.tracking.delay[2] - found.tracking.delay[0] == pytest.approx(0.004, abs=3e-4)
    assert np.count_nonzero(told) >= 4
    for peak in found.peaks:
        assert abs(peak.by_joint["joint_3"]) > 10.0 * abs(peak.by_joint["joint_4"])
        assert peak.executed - peak.planned == pytest.approx(sum(peak.by_joint.values()), rel=0.5, abs=2e-4)


def test_a_delay_behind_the_command_in_the_log(plan: Plan) -> None:
    log = log_of(plan, delays=0.006)
    ahead = log_of(plan, noise=0.0)
    found = executed(replace(log, command=ahead.position), plan.scene)
    assert found.tracking is not None
    assert found.tracking.of_command
    assert found.tracking.delay[[0, 2]] == pytest.approx([0.006, 0.006], abs=1e-4)
    assert found.clock == found.recorded.begin


def test_more_noise_makes_wider_bands(plan: Plan, found: Executed) -> None:
    loud = executed(log_of(plan, noise=1e-4), plan.scene)
    for row in loud.judgement.certificate.rows:
        if row.constraint in ("slip", "joint speed") and row.subject != "joint_4":
            own = RowId(row.constraint, row.subject)
            assert loud.bands[own] > 3.0 * found.bands[own]


@pytest.mark.slow
def test_measured_heights_are_aligned(plan: Plan, found: Executed) -> None:
    t = np.arange(0.0, 7.0, 1 / 60)
    height = np.interp(t - 1.3, found.judgement.replay.t, found.heights["c1"], left=0.0)
    beside = executed(log_of(plan), plan.scene, plan=plan, measured={"c1": Heights(t, height)})
    assert beside.measured["c1"].shift == pytest.approx(1.3, abs=5e-3)
    assert beside.measured["c1"].correlation > 0.99


def test_record_and_sentences(found: Executed) -> None:
    table = executed_table(found)
    assert table["ok"] is found.ok and table["outcome"] == found.outcome != NOT_CERTIFIED
    assert {row["outcome"] for row in table["executed"]["rows"]} == set(found.outcomes.values())
    assert table["executed"]["rows"][0]["band"] >= 0.0
    assert set(table["noise_rad"]) == set(found.scene.robot.joints)
    assert len(log_lines(found)) == 3
    assert "the plan begins at 0.500" in tracking_lines(found)[0]
    assert all(row.constraint for row in undecided(found))
    assert table["left_at_end"].keys() == found.heights.keys()
    for name, left in table["left_at_end"].items():
        count = found.scene.slosh_modes * 4  # displacement and velocity along x and y
        assert np.shape(left["covariance"]) == (count, count), name


# --- what a log leaves open -------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("verdict_alone")
def test_a_log_without_noise_is_judged_as_the_plan(plan: Plan) -> None:
    """Its samples are the plan's own: rows agree without a band, those on the end too."""
    found = executed(log_of(plan, noise=0.0, jitter=0.0), plan.scene, plan=plan)
    assert found.recorded.is_exact and found.ok and found.word == plan.certificate.word
    assert not any(found.bands.values())
    planned = {row.id: row for row in plan.certificate.rows}
    for row in found.judgement.certificate.rows:
        require_agreement(row, planned[row.id], 2e-3 * planned[row.id].size)


def test_distances_have_bands_no_wider_than_noise_moves_the_bodies(plan: Plan) -> None:
    """No point of the arm is 3 m from a joint: noise of six joints moves it by less than 18 m times itself."""
    bands = []
    for noise in (1e-6, 1e-5):
        found = executed(log_of(plan, noise=noise), plan.scene)
        rows = [row for row in found.judgement.certificate.rows if row.constraint == Clearance.name]
        assert all(found.bands[row.id] < 18.0 * noise * WIDE for row in rows)
        bands.append([found.bands[RowId(Clearance.name, subject)] for subject in (OTHERS, "holder to link_4")])
    assert np.all(np.array(bands[1]) > 3.0 * np.array(bands[0])) and np.all(np.array(bands[0]) > 0.0)


@pytest.mark.usefixtures("verdict_alone")
@pytest.mark.parametrize(
    ("rate", "noise", "jitter"),
    [  # each noise at the least rate and at a higher one, each rate with noise and without or with little
        *[(125.0, 0.0, 3e-4), (125.0, 1e-5, 1e-4), (125.0, 1e-4, 3e-4)],
        *[(250.0, 1e-5, 1e-4), (500.0, 0.0, 3e-4), (1000.0, 1e-4, 3e-4)],
    ],
)
def test_a_run_as_planned_is_never_refused_for_its_log(plan: Plan, rate: float, noise: float, jitter: float) -> None:
    found = executed(log_of(plan, noise=noise, jitter=jitter, rate=rate), plan.scene, plan=plan)
    assert found.outcome != NOT_CERTIFIED
    assert noise < 1e-4 or (found.outcome == OPEN and found.word == "cannot be told at this noise")


def test_a_run_that_breaks_a_limit_is_refused_through_its_noise(plan: Plan) -> None:
    """The same motion in 0.55 of its time breaks friction and heights by more than noise of 1e-5 rad can hide."""
    for noise in (0.0, 1e-5):
        log = log_of(plan, noise=noise, jitter=0.0)
        found = executed(replace(log, t=0.55 * log.t), plan.scene)
        assert found.outcome == NOT_CERTIFIED and not found.ok
        assert {row.constraint for row in failing(found)} & {"slip", "slosh height", "residual height"}
        assert "not certified: of" in verdict(found) and " fail" in verdict(found)


@pytest.mark.usefixtures("verdict_alone")
def test_samples_that_are_missing_are_told_from_stamps_that_are_late(plan: Plan) -> None:
    log = log_of(plan, noise=1e-6, jitter=5e-4)
    kept = np.ones(len(log.t), dtype=bool)
    for row in (200, 430, 431, 432, 433, 700):
        kept[row] = False
    found = executed(replace(log, t=log.t[kept], position=log.position[kept]), plan.scene, plan=plan)
    assert found.recorded.sampling.missing == 6
    assert found.outcome != NOT_CERTIFIED
    assert np.max(found.recorded.smooth.noise) < 1e-5


def test_outcomes_of_a_row() -> None:
    row = Row("slip", "c1", "1", 1.0, 0.99, 0.01, 0.5, True)
    for margin, band, smoothing, wanted in (
        (0.01, 0.0, 0.0, CERTIFIED),
        (0.01, 0.002, 0.0, CERTIFIED),
        (0.01, 0.02, 0.0, OPEN),
        (0.01, 0.0, 1.0, CERTIFIED),
        (-0.01, 0.0, 0.0, NOT_CERTIFIED),
        (-0.01, 0.0, 0.02, OPEN),
        (-0.01, 0.02, 0.0, OPEN),
        (-0.01, np.inf, 0.0, OPEN),
    ):
        assert outcome(replace(row, worst_margin=margin), {row.id: band}, {row.id: smoothing}, 40) == wanted
    # more rows are compared, so a row must fail by more
    band = {row.id: 0.004}
    assert outcome(replace(row, worst_margin=-0.006), band, {}, 1) == NOT_CERTIFIED
    assert outcome(replace(row, worst_margin=-0.006), band, {}, 50) == OPEN


def test_drawn_motions_on_a_finer_grid_and_those_that_cannot_be_followed() -> None:
    t, fine = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 21)

    def height(at: np.ndarray, more: float) -> tuple[Trace, ...]:
        return (limit_trace("slosh height", "c1", "m", 0.02, at, 0.01 * at + more),)

    rough = height(t, 0.0)
    drawn = [height(fine, 1e-3), height(t, -1e-3)]
    assert row_bands(rough, drawn)[rough[0].id] == pytest.approx(2.4469e-3, rel=1e-3)  # Student's, 6 degrees of freedom
    np.testing.assert_allclose(height_bands(rough, drawn, t)["c1"], 2.4469e-3, rtol=1e-3)
    assert row_bands(rough, [*drawn, None])[rough[0].id] == np.inf
    assert np.all(np.isinf(height_bands(rough, [*drawn, None], t)["c1"]))


# --- logs that are refused ------------------------------------------------------------------------------------------


def refusal(plan: Plan, change: Callable[[np.ndarray], np.ndarray], *, of_plan: bool = True) -> str:
    log = log_of(plan)
    with pytest.raises(ScenarioError) as caught:
        executed(replace(log, position=change(log.position)), plan.scene, plan=plan if of_plan else None)
    return str(caught.value)


def test_degrees_taken_for_radians(plan: Plan) -> None:
    assert "the log is in degrees (--unit deg" in refusal(plan, np.degrees)


def test_a_log_that_stops_midway(plan: Plan) -> None:
    log = log_of(plan)
    cut = len(log.t) // 2
    short = replace(log, t=log.t[:cut], position=log.position[:cut])
    with pytest.raises(ScenarioError, match=r"the log stops midway: joint_\d moves at .* rad/s"):
        executed(short, plan.scene)
    with pytest.raises(ScenarioError, match="the log begins midway"):
        executed(replace(log, t=log.t[cut:], position=log.position[cut:]), plan.scene)


def test_another_zero_is_told_with_the_option_that_helps(plan: Plan) -> None:
    turned = refusal(plan, lambda position: position + np.pi * np.eye(6)[5])
    assert "joint_6 is 180 deg from where the plan begins" in turned
    assert '--offset joint_6="-180 deg"' in turned


def test_another_robot_leans_its_tray(plan: Plan) -> None:
    assert "the tray leans by" in refusal(plan, lambda position: position[:, ::-1] * 0.3, of_plan=False)


def test_an_arm_that_never_moves(plan: Plan) -> None:
    assert "the arm never moves" in refusal(plan, lambda position: np.repeat(position[:1], len(position), axis=0))


def test_the_log_of_another_motion(plan: Plan, gentle_plan: Callable[..., Plan]) -> None:
    slower = log_of(plan)
    stretched = replace(slower, t=1.6 * slower.t)
    with pytest.raises(ScenarioError, match="the log of another motion"):
        executed(stretched, plan.scene, plan=plan)


def test_a_height_of_no_liquid(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match="--measured c9: no object of this name with a liquid; there are: c1"):
        executed(log_of(plan), plan.scene, measured={"c9": Heights(np.arange(9.0), np.arange(9.0))})


# --- the laboratory's logs ------------------------------------------------------------------------------------------


@pytest.mark.oracle
@pytest.mark.slow
@pytest.mark.parametrize(("name", "doubled", "peak"), [("run-2a", 0, 16.1e-3), ("run-2a-not-optimised", 13, 64e-3)])
def test_logs_of_the_laboratory(name: str, doubled: int, peak: float) -> None:
    scene = read_scenario("matrix-liquid")
    log = read_log(measured_data(f"executed-logs/{name}.csv"), scene.robot, offsets={"joint_6": np.pi})
    found = executed(log, scene)
    assert not found.ok
    assert found.recorded.sampling.even
    assert found.recorded.sampling.doubled == doubled
    assert found.recorded.sampling.resolution == pytest.approx(np.full(6, 1e-7), rel=1e-3)
    assert np.all(found.recorded.smooth.noise < 5e-5)
    assert max(map(np.max, found.heights.values())) == pytest.approx(peak, rel=0.02)


@pytest.mark.oracle
@pytest.mark.slow
def test_the_published_run_and_its_figure() -> None:
    """The lab's own prediction from its executed joints, and the two cups that were filmed."""
    scene = read_scenario("matrix-liquid")
    log = read_log(measured_data("matrix-d3/executed-joints-liquid.csv"), scene.robot, offsets={"joint_6": -np.pi})
    films = {name: read_heights(measured_data(f"matrix-d3/measured-height-{name}.csv")) for name in ("c1", "c3")}
    found = executed(log, scene, measured=films)
    for name in ("c1", "c2", "c3", "c4"):
        theirs = read_heights(measured_data(f"matrix-d3/predicted-height-{name}.csv"))
        ours = np.interp(theirs.t - found.clock, found.judgement.replay.t, found.heights[name])
        # A log without noise is taken as it is: 6.4e-5 m at worst. Splines of 50 Hz, as through noise, are at
        # 5.0e-5 m.
        assert np.sqrt(np.mean((ours - theirs.height) ** 2)) < 7e-5
    assert found.measured["c1"].correlation == pytest.approx(0.966, abs=0.005)
    assert found.measured["c3"].correlation == pytest.approx(0.835, abs=0.01)
    assert 1e3 * found.measured["c1"].measured_peak == pytest.approx(17.4, abs=0.01)


def test_what_happens_is_told_apart_from_limits_of_the_arm(plan: Plan, found: Executed) -> None:
    """A friction with a tenth in reserve may be passed by a tenth before anything slides."""
    assert "nothing spills, slides, turns, tips, lifts or touches; nearest to it: " in happening_line(
        found.without_reserve
    )
    slips = [row for row in found.judgement.certificate.rows if row.constraint == Slip.name]
    reserve = 1.0 - plan.scene.cargo[0].friction_reserve
    assert reserve < 1.0 and slips
    for row in slips:
        assert found.without_reserve[row.id] == pytest.approx(reserve * row.use, rel=1e-3)


def test_what_happens_is_named_once_and_by_what_it_is() -> None:
    uses = {
        RowId("slip", "c1"): 1.37,
        RowId("slosh height", "c2"): 1.2,
        RowId("residual height", "c2"): 1.1,
        RowId("clearance", "tray to link_4"): 1.05,
        RowId("tip", "c1"): 0.4,
    }
    assert happening_line(uses) == (
        "on the tray: c1 slides (137.0 % of the measured friction), c2 spills (120.0 % of the way to the rim) "
        "and tray and link_4 touch"
    )
    calm = happening_line({row: 0.5 * use for row, use in uses.items()})
    assert calm.endswith("lifts or touches; nearest to it: slip of c1, 68.5 % of the measured friction")


def test_rows_about_the_tray_come_before_those_of_the_arm() -> None:
    def row(constraint: str, use: float) -> Row:
        return Row(constraint, "a", "-", 1.0, use, 1.0 - use, 0.0, use <= 1.0)

    rows = [row("joint acceleration", 1.5), row("slip", 1.02), row("tilt", 1.01), row("slosh height", 0.9)]
    ordered = [item.constraint for item in tray_first(rows)]
    assert ordered == ["slip", "slosh height", "joint acceleration", "tilt"]


def test_what_the_second_order_adds_to_a_height_counts_once(gentle_plan: Callable[..., Plan]) -> None:
    """The way to the rim of a prism is its freeboard, and the height is that of the certificate."""
    made = gentle_plan("matrix-liquid-tilt", cargo=1)
    judged = judge(made.trajectory, made.scene)
    (row,) = [row for row in judged.certificate.rows if row.constraint == SloshHeight.name]
    cup = made.scene.cargo[0]
    assert cup.filling is not None and row.linear_value is not None
    assert abs(row.worst_value - row.linear_value) > 1e-4
    use = without_reserve(judged.replay, made.scene, judged.certificate.rows)[row.id]
    assert use == pytest.approx(row.worst_value / (cup.container.height - cup.filling.liquid_height), rel=2e-3)
