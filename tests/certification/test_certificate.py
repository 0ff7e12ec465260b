"""A certificate that cannot be fooled: a good motion is certified, every way to spoil it is found by the right row."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from nospill.certification.certificate import certify, judge
from nospill.certification.verdict import Certificate
from nospill.certification.wording import remedy
from nospill.errors import ModelError, PlanFolderError
from nospill.laws.constraints import CONSTRAINTS
from nospill.motion.trajectory import Trajectory
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record

RECORD_ROWS = {
    "path position",
    "path attitude",
    "path covered",
    "rest at the ends",
    "rest as played",
    "recorded speed",
    "recorded acceleration",
    "recorded position",
    "recorded attitude",
    "even sampling",
}
LEVEL_ROWS = {("tilt", "theta_x"), ("tilt", "theta_y")}
"""Of a tray whose tilt is fixed."""


@pytest.fixture(scope="module")
def good(smooth_motion) -> tuple[Scene, Trajectory]:
    """One cup off the middle of a level tray, three seconds, ends within the residual bound."""
    motion = smooth_motion("matrix-liquid-soft-end", cargo=1)
    return motion.scene, motion.trajectory


@pytest.fixture(scope="module")
def solid(smooth_motion) -> tuple[Scene, Trajectory]:
    """One solid on a tray that leans: no liquid to integrate, so that it is judged in a moment."""
    motion = smooth_motion("matrix-rigid", cargo=1, stretch=1.3, tilt=(0.05, -0.03))
    return motion.scene, motion.trajectory


@pytest.fixture(scope="module")
def good_certificate(good) -> Certificate:
    scene, trajectory = good
    return certify(trajectory, scene)


def failed(certificate: Certificate) -> set[str]:
    assert certificate.ok == all(row.ok for row in certificate.rows)
    return {row.constraint for row in certificate.rows if not row.ok}


def with_rows(trajectory: Trajectory, name: str, change: Callable[[np.ndarray], object]) -> Trajectory:
    """A copy of the trajectory whose column `name` has been changed in place."""
    values = getattr(trajectory, name).copy()
    change(values)
    return replace(trajectory, **{name: values})


def first_rows(trajectory: Trajectory, count: int) -> Trajectory:
    parts = {
        field.name: getattr(trajectory, field.name)[:count]
        for field in fields(trajectory)
        if field.name not in ("joints", "slosh", "in_motion")
    }
    return replace(trajectory, **parts)


def with_cargo(scene: Scene, **changes) -> Scene:
    return replace(scene, cargo=(replace(scene.cargo[0], **changes),))


def test_good_motion_is_certified(good, good_certificate):
    scene, _ = good
    assert good_certificate.ok and failed(good_certificate) == set()
    assert good_certificate.grid_hz >= 2000
    rows = [row for row in good_certificate.rows if row.constraint != "clearance"]
    assert 0 < len(good_certificate.rows) - len(rows) < 8
    subjects = {(row.constraint, row.subject) for row in rows}
    assert len(subjects) == len(rows)
    expected = {(constraint.name, subject) for constraint in CONSTRAINTS for subject in constraint.subjects(scene)}
    assert {pair for pair in subjects if pair[0] not in RECORD_ROWS} == expected | LEVEL_ROWS
    assert {pair[0] for pair in subjects - LEVEL_ROWS} - {pair[0] for pair in expected} == RECORD_ROWS


@pytest.mark.parametrize(
    ("name", "tilt"), [("matrix-liquid-soft-end", (0.0, 0.0)), ("mixed-tray", (0.03, -0.04))], ids=["level", "tilting"]
)
def test_whole_examples_are_certified_when_moved_slowly(smooth_motion, name, tilt):
    motion = smooth_motion(name, stretch=1.3, tilt=tilt)
    certificate = certify(motion.trajectory, motion.scene)
    assert certificate.ok, failed(certificate)


def test_rows_say_where_and_when(good, good_certificate):
    scene, trajectory = good
    judgement = judge(trajectory, scene)
    assert judgement.certificate == good_certificate, "the verdict is the same each time"
    for trace in judgement.traces:
        row = next(r for r in good_certificate.rows if (r.constraint, r.subject) == (trace.constraint, trace.subject))
        assert row.worst_margin == np.min(trace.margin)
        assert row.at_s in trace.t
        assert row.worst_value == trace.value[np.argmin(trace.margin)]
        assert row.ok == (row.worst_margin >= 0)
    worst = good_certificate.worst
    relative = {row: row.worst_margin / max(abs(row.limit), 1e-9) for row in good_certificate.rows}
    assert relative[worst] == min(relative.values())


def test_table_for_the_file(good_certificate):
    table = json.loads(json.dumps(good_certificate.to_dict()))
    assert list(table) == ["ok", "grid_hz", "rows", "published", "modes", "self_collision"]
    assert list(table["rows"][0]) == [
        "constraint",
        "subject",
        "unit",
        "limit",
        "worst_value",
        "worst_margin",
        "at_s",
        "ok",
    ]
    assert all(isinstance(row["ok"], bool) for row in table["rows"])


class TestSpoiledRecord:
    """The scene is what it was; the file is not."""

    def test_one_joint_sample_off_by_two_milliradians(self, solid):
        scene, trajectory = solid

        def nudge(values: np.ndarray) -> None:
            values[700, 2] += 2e-3

        broken = failed(certify(with_rows(trajectory, "joint_position", nudge), scene))
        assert {"path position", "recorded speed", "recorded acceleration"} <= broken

    def test_one_sample_off_by_a_little_at_the_wrist(self, solid):
        """A tenth of a milliradian: invisible as a position, not as a speed."""
        scene, trajectory = solid

        def nudge(values: np.ndarray) -> None:
            values[700, 5] += 1e-4

        assert {"recorded speed", "recorded acceleration"} <= failed(
            certify(with_rows(trajectory, "joint_position", nudge), scene)
        )

    def test_time_scaled(self, solid):
        scene, trajectory = solid
        broken = failed(certify(replace(trajectory, t=0.95 * trajectory.t), scene))
        assert {"even sampling", "recorded speed"} <= broken

    def test_time_scaled_with_all_rates(self, solid):
        """A consistent record of a faster motion: its samples do not come at the rate they are played at."""
        scene, trajectory = solid
        factor = 0.95
        changed = {"t": factor * trajectory.t}
        for name in ("s", "tilt", "joint"):
            for order, suffix in (
                (1, "_speed" if name == "joint" else "_rate"),
                (2, "_acceleration"),
            ):
                changed[name + suffix] = getattr(trajectory, name + suffix) / factor**order
        assert failed(certify(replace(trajectory, **changed), scene)) == {"even sampling"}

    def test_whole_path_shifted(self, solid):
        """The joints carry the tray along the path, five degrees of joint 1 beside it."""
        scene, trajectory = solid

        def shift(values: np.ndarray) -> None:
            values[:, 0] += np.deg2rad(5)

        broken = failed(certify(with_rows(trajectory, "joint_position", shift), scene))
        assert {"path position", "path attitude", "recorded position", "recorded attitude"} <= broken

    def test_path_parameter_shifted(self, solid):
        scene, trajectory = solid

        def shift(values: np.ndarray) -> None:
            values[600:700] += 1e-3

        assert {"path position", "path jerk"} <= failed(certify(with_rows(trajectory, "s", shift), scene))

    def test_last_sample_missing_the_end(self, solid):
        scene, trajectory = solid

        def shorten(values: np.ndarray) -> None:
            values[-1] = 1 - 1e-6

        assert "path covered" in failed(certify(with_rows(trajectory, "s", shorten), scene))

    def test_starts_late(self, solid):
        scene, trajectory = solid

        def late(values: np.ndarray) -> None:
            values[0] = 1e-6

        assert "path covered" in failed(certify(with_rows(trajectory, "s", late), scene))

    def test_truncated(self, solid):
        scene, trajectory = solid
        cut = first_rows(trajectory, 900)
        broken = failed(certify(cut, scene))
        assert {"path covered", "rest at the ends", "recorded speed"} <= broken

    def test_recorded_speeds_wrong(self, solid):
        scene, trajectory = solid

        def slower(values: np.ndarray) -> None:
            values *= 0.99

        assert failed(certify(with_rows(trajectory, "joint_speed", slower), scene)) == {"recorded speed"}

    def test_recorded_accelerations_wrong(self, solid):
        scene, trajectory = solid

        def more(values: np.ndarray) -> None:
            values[300, 1] += 2.0

        assert failed(certify(with_rows(trajectory, "joint_acceleration", more), scene)) == {"recorded acceleration"}

    def test_recorded_pose_wrong(self, solid):
        scene, trajectory = solid

        def lift(values: np.ndarray) -> None:
            values[800, 2] += 2e-4

        def turn(values: np.ndarray) -> None:
            values[:] = np.roll(values, 1, axis=1)

        assert failed(certify(with_rows(trajectory, "tray_position", lift), scene)) == {"recorded position"}
        assert failed(certify(with_rows(trajectory, "tray_quaternion", turn), scene)) == {"recorded attitude"}

    def test_tilt_that_the_joints_do_not_make(self, solid):
        scene, trajectory = solid

        def lean(values: np.ndarray) -> None:
            values[:, 0] += 2e-4

        assert failed(certify(with_rows(trajectory, "tilt", lean), scene)) == {"path attitude"}

    def test_tray_that_leans_where_its_tilt_is_fixed(self, solid):
        """The record says that it leans, and the joints do as it says: the scenario forbids it."""
        scene, trajectory = solid
        level = replace(scene, motion=replace(scene.motion, tilt_free=False))
        certificate = certify(trajectory, level)
        assert failed(certificate) == {"tilt", "path attitude"}
        reached = {row.subject: row.worst_value for row in certificate.rows if row.constraint == "tilt"}
        assert reached == pytest.approx(dict(zip(("theta_x", "theta_y"), np.abs(trajectory.tilt).max(0), strict=True)))

    def test_tilt_recorded_of_a_level_tray(self, good):
        scene, trajectory = good

        def lean(values: np.ndarray) -> None:
            values[300, 1] = 2e-4

        assert failed(certify(with_rows(trajectory, "tilt", lean), scene)) == {"tilt"}

    def test_recorded_heights_do_not_count(self, good, good_certificate):
        """The liquids are integrated again: what the file says of them changes nothing."""
        scene, trajectory = good
        track = trajectory.slosh["c1"]
        flat = replace(track, displacement=0 * track.displacement, velocity=0 * track.velocity, height=0 * track.height)
        assert certify(replace(trajectory, slosh={"c1": flat}), scene) == good_certificate

    def test_uneven_sampling(self, solid):
        scene, trajectory = solid

        def late(values: np.ndarray) -> None:
            values[500] += 4e-4

        assert "even sampling" in failed(certify(with_rows(trajectory, "t", late), scene))

    @pytest.mark.parametrize("name", ["joint_position", "joint_speed", "joint_acceleration", "s", "t", "tray_position"])
    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_not_a_number(self, solid, name, value):
        scene, trajectory = solid

        def spoil(values: np.ndarray) -> None:
            values[300] = value

        with pytest.raises(PlanFolderError, match=rf"{name} is not a finite number at row 300"):
            certify(with_rows(trajectory, name, spoil), scene)

    def test_time_that_stands_still_or_runs_back(self, solid):
        scene, trajectory = solid
        for value in (trajectory.t[299], trajectory.t[298]):

            def stop(values: np.ndarray, value: float = value) -> None:
                values[300] = value

            with pytest.raises(PlanFolderError, match=r"t does not increase from .* at row 299"):
                certify(with_rows(trajectory, "t", stop), scene)

    def test_quaternion_of_the_wrong_length(self, solid):
        scene, trajectory = solid

        def stretch(values: np.ndarray) -> None:
            values[7] *= 0.0

        with pytest.raises(PlanFolderError, match="quaternion at row 7 has length 0"):
            certify(with_rows(trajectory, "tray_quaternion", stretch), scene)

    def test_columns_of_different_length(self, solid):
        scene, trajectory = solid
        with pytest.raises(PlanFolderError, match="rows of s, "):
            certify(replace(trajectory, s=trajectory.s[:-1]), scene)

    def test_wild_joints(self, good):
        """Noise that no liquid survives: an error in words or rows that fail, never a verdict of success."""
        scene, trajectory = good
        random = np.random.default_rng(1)

        def shake(values: np.ndarray) -> None:
            values += random.normal(size=values.shape) * 0.3

        try:
            certificate = certify(with_rows(trajectory, "joint_position", shake), scene)
        except ModelError as error:
            assert "leaves its cup" in str(error)
        else:
            assert {"path position", "joint speed", "slip"} <= failed(certificate)


@pytest.mark.slow
@pytest.mark.parametrize("end", ["residual", "still"])
def test_rest_appended_to_a_motion(good, end):
    """A minute of rest, recorded as if the path were not yet covered: what the liquid does in it still counts."""
    scene, trajectory = good
    rest = 30000
    columns = {
        field.name: np.concatenate([values, np.repeat(values[-1:], rest, axis=0)])
        for field in fields(trajectory)
        if field.name not in ("joints", "slosh", "t", "in_motion")
        and (values := getattr(trajectory, field.name)) is not None
    }
    columns["s"][len(trajectory.t) : -1] = 1 - 3e-7
    columns["s_rate"][-rest:-1] = 1e-9
    t = np.arange(len(trajectory.t) + rest) / scene.output_rate
    motion = replace(scene.motion, end=end, residual_fraction=0.04)
    broken = failed(certify(replace(trajectory, t=t, **columns), replace(scene, motion=motion)))
    assert {"residual": "residual height", "still": "still at the end"}[end] in broken


def test_samples_too_far_apart(solid):
    """Between samples 0.25 s apart the joints leave the path, and start and stop with a jump.

    The motion that the samples are of keeps all limits.
    """
    scene, trajectory = solid
    every = np.minimum(np.arange(0, len(trajectory.t) + 124, 125), len(trajectory.t) - 1)
    columns = {
        field.name: getattr(trajectory, field.name)[every]
        for field in fields(trajectory)
        if field.name not in ("joints", "slosh", "in_motion")
    }
    coarse = replace(trajectory, **columns | {"t": np.arange(len(every)) / 4.0})
    scene = replace(scene, robot=replace(scene.robot, max_speed=0.4 * scene.robot.max_speed))
    rows = {row.constraint: row for row in certify(coarse, replace(scene, output_rate=4.0)).rows}
    assert not rows["path position"].ok and not rows["rest as played"].ok
    instants = {name: rows[name].at_s * 4.0 for name in ("path position", "path attitude")}
    assert all(abs(instant - round(instant)) > 1e-6 for instant in instants.values())
    assert rows["rest as played"].worst_value > 5e-3
    assert "hold_after of 1.5 s" in remedy(rows["rest as played"], 4.0)
    assert "Between samples 250 ms apart the joints leave the path" in remedy(rows["path position"], 4.0)
    assert remedy(rows["path position"], 500.0) == remedy(rows["joint speed"], 4.0) == ""
    settled = replace(scene, output_rate=4.0, motion=replace(scene.motion, hold_before=1.5, hold_after=1.5))
    assert "rest as played" not in failed(certify(coarse, settled))


class TestSpoiledScene:
    """The file is what it was; the scene asks for more."""

    @pytest.mark.parametrize("fidelity", ["deliverable", "full"])
    def test_film_of_water_whose_trough_meets_the_bottom(self, changed_scene, fidelity):
        """One millimetre of water under a limit of 15 mm: the bottom falls dry long before the crest is too high."""
        scene = changed_scene("matrix-liquid", {"fidelity": fidelity, "cargo.0.liquid_height": "1 mm"})
        scene = replace(scene, cargo=scene.cargo[:1])
        trajectory = smooth_record(scene, joint_path_of(scene), 200, Start(stretch=1.3))
        certificate = certify(trajectory, scene)
        rows = {row.constraint: row for row in certificate.rows}
        assert not rows["trough"].ok and rows["trough"].limit == 1e-3
        assert rows["trough"].worst_value == pytest.approx(rows["slosh height"].worst_value, rel=1e-9)
        assert rows["slosh height"].ok

    def test_less_friction(self, good):
        scene, trajectory = good
        assert failed(certify(trajectory, with_cargo(scene, friction=0.12))) == {"slip"}

    def test_less_friction_at_a_short_lever(self, good):
        scene, trajectory = good
        assert {"slip", "twist"} <= failed(certify(trajectory, with_cargo(scene, friction=0.0005)))

    def test_cup_moved_on_the_tray(self, good, good_certificate):
        """Where it stands now the water rises higher than the limit that it just kept where it stood."""
        scene, trajectory = good
        reached = next(row for row in good_certificate.rows if row.constraint == "slosh height").worst_value
        filling = replace(scene.cargo[0].filling, max_slosh_height=1.001 * reached)
        moved = certify(trajectory, with_cargo(scene, filling=filling, position=scene.cargo[0].position * (-1, 1)))
        assert "slosh height" in failed(moved)
        for ours, theirs in zip(moved.rows, good_certificate.rows, strict=True):
            changed = ours.constraint in {"slosh height", "residual height", "slip", "tip"}
            assert (ours.worst_value != pytest.approx(theirs.worst_value, rel=1e-9)) == changed, ours.constraint

    def test_lower_slosh_limit(self, good, good_certificate):
        scene, trajectory = good
        reached = next(row for row in good_certificate.rows if row.constraint == "slosh height").worst_value
        for factor, broken in ((1.001, False), (0.999, True)):
            filling = replace(scene.cargo[0].filling, max_slosh_height=factor * reached)
            certificate = certify(trajectory, with_cargo(scene, filling=filling))
            assert ("slosh height" in failed(certificate)) == broken

    def test_smaller_residual(self, good):
        scene, trajectory = good
        stricter = replace(scene, motion=replace(scene.motion, residual_fraction=0.04))
        assert failed(certify(trajectory, stricter)) == {"residual height"}

    def test_end_perfectly_still(self, good):
        scene, trajectory = good
        stricter = replace(scene, motion=replace(scene.motion, end="still"))
        assert failed(certify(trajectory, stricter)) == {"still at the end"}

    def test_narrower_joint(self, solid):
        scene, trajectory = solid
        upper = scene.robot.upper.copy()
        upper[0] = trajectory.joint_position[:, 0].max() - 1e-5
        certificate = certify(trajectory, replace(scene, robot=replace(scene.robot, upper=upper)))
        assert failed(certificate) == {"joint position"}
        assert [row.subject for row in certificate.rows if not row.ok] == [scene.robot.joints[0]]

    def test_slower_joint(self, solid):
        scene, trajectory = solid
        speed = scene.robot.max_speed.copy()
        speed[3] = 0.999 * np.abs(trajectory.joint_speed[:, 3]).max()
        certificate = certify(trajectory, replace(scene, robot=replace(scene.robot, max_speed=speed)))
        assert failed(certificate) == {"joint speed"}
        assert [row.subject for row in certificate.rows if not row.ok] == [scene.robot.joints[3]]

    def test_less_jerk(self, good, good_certificate):
        scene, trajectory = good
        reached = abs(next(row for row in good_certificate.rows if row.constraint == "path jerk").worst_value)
        gentle = replace(scene, motion=replace(scene.motion, path_jerk_limit=0.99 * reached))
        assert failed(certify(trajectory, gentle)) == {"path jerk"}

    def test_tall_narrow_object_tips(self, solid):
        scene, trajectory = solid
        total = replace(scene.cargo[0].total, centre=np.array((0.0, 0.0, 0.5)))
        assert failed(certify(trajectory, with_cargo(scene, total=total))) == {"tip"}

    def test_other_path(self, solid):
        scene, trajectory = solid
        assert "path position" in failed(certify(trajectory, replace(scene, path=read_scenario("pp-two-cups").path)))

    def test_tray_mounted_elsewhere(self, solid):
        scene, trajectory = solid
        tool = scene.tray.tool
        raised = replace(tool, position=tool.position + np.array((0, 0, 0.001)))
        higher = replace(scene, tray=replace(scene.tray, tool=raised))
        assert {"path position", "recorded position"} <= failed(certify(trajectory, higher))
        turned = replace(scene, tray=replace(scene.tray, tool=replace(tool, yaw=tool.yaw + 0.001)))
        assert {"path attitude", "recorded attitude"} <= failed(certify(trajectory, turned))

    def test_other_rate_of_the_controller(self, solid):
        scene, trajectory = solid
        assert failed(certify(trajectory, replace(scene, output_rate=250.0))) == {"even sampling"}

    def test_other_robot_or_other_cups(self, good):
        scene, trajectory = good
        with pytest.raises(PlanFolderError, match="joints"):
            certify(replace(trajectory, joints=("a", *trajectory.joints[1:])), scene)
        with pytest.raises(PlanFolderError, match=r"liquids .* are c1 \(2\), those of the scene other \(2\)"):
            certify(trajectory, with_cargo(scene, name="other"))
        with pytest.raises(PlanFolderError, match=r"those of the scene none"):
            certify(trajectory, replace(scene, cargo=()))


def test_too_fast_motion_names_what_gives_way():
    """A third of the duration: cups slide and spill, joints run too fast, all at once; the record itself is fine."""
    scene = read_scenario("matrix-liquid-soft-end")
    arm = joint_path_of(scene)
    trajectory = smooth_record(scene, arm, 200, Start(stretch=0.35))
    broken = failed(certify(trajectory, scene))
    assert {"slosh height", "residual height", "slip", "joint speed"} <= broken
    assert not broken & {"path position", "path attitude", "path covered", "even sampling", "rest at the ends"}
