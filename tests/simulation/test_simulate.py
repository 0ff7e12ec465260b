"""The height of one container's liquid along given motions: closed forms, invariants, and the errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

import nospill as ns
from nospill.cli import app
from nospill.errors import ModelError, ScenarioError
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.simulation.motion_file import read_heights, read_motion
from nospill.simulation.simulate import SloshSimulation, simulate_slosh

CUP = {"shape": "cylinder", "radius": "49 mm", "height": "150 mm", "liquid": "water", "liquid_height": "80 mm"}
BOX = {
    "shape": "box",
    "length": "70 mm",
    "width": "50 mm",
    "height": "90 mm",
    "liquid": "water",
    "liquid_height": "49 mm",
}
RADIUS, FIRST_ROOT = 0.049, 1.8411837813406595
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
RATE = 500.0


def clock(duration: float, rate: float = RATE) -> np.ndarray:
    return np.arange(round(duration * rate) + 1) / rate


def along_x(x: np.ndarray) -> np.ndarray:
    return np.column_stack([x, 0 * x, 0 * x])


def upright(t: np.ndarray) -> np.ndarray:
    return np.tile(UPRIGHT, (len(t), 1))


def quintic(t: np.ndarray, duration: float) -> np.ndarray:
    u = np.clip(t / duration, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def simulate_translation(x: np.ndarray, t: np.ndarray, cup: dict[str, str] = CUP, **options: object) -> SloshSimulation:
    return simulate_slosh(cup, t, along_x(x), upright(t), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("degrees", [5.0, 20.0, -35.0])
def test_a_container_that_leans_for_ever_has_a_level_surface(axis: str, degrees: float) -> None:
    t = clock(0.2)
    quaternion = np.tile(Rotation.from_euler(axis, degrees, degrees=True).as_quat(), (len(t), 1))
    level = RADIUS * np.tan(np.radians(abs(degrees)))
    options = {"position": np.zeros((len(t), 3)), "quaternion": quaternion}
    for modes in (1, 3):
        corrected = simulate_slosh(CUP, t, **options, modes=modes, height="corrected")
        assert corrected.height == pytest.approx(np.full(len(t), level), rel=1e-6)
    roots = FIRST_ROOT, 5.3314427735250325
    carried = np.cumsum([2 / (root**2 - 1) for root in roots])
    for modes in (1, 2):
        plain = simulate_slosh(CUP, t, **options, modes=modes)
        assert plain.height == pytest.approx(np.full(len(t), level * carried[modes - 1]), rel=1e-6)
    many = simulate_slosh(CUP, t, **options, modes=20)
    assert many.height[0] == pytest.approx(level, rel=0.02) and many.height[0] < level


def test_a_tilted_box_has_its_corner_up() -> None:
    t = clock(0.1)
    quaternion = np.tile(Rotation.from_euler("y", 10, degrees=True).as_quat(), (len(t), 1))
    found = simulate_slosh(BOX, t, np.zeros((len(t), 3)), quaternion, height="corrected")
    assert found.height == pytest.approx(np.full(len(t), 0.035 * np.tan(np.radians(10.0))), rel=1e-6)


def test_a_turn_about_its_own_axis_moves_nothing_in_a_round_cup() -> None:
    t = clock(2.0)
    quaternion = Rotation.from_euler("z", 9.0 * quintic(t, 1.5)[:, None]).as_quat()
    found = simulate_slosh(CUP, t, np.zeros((len(t), 3)), quaternion, modes=2, height="corrected")
    assert found.peak < 1e-12
    box = simulate_slosh(BOX, t, np.zeros((len(t), 3)), quaternion, modes=2, height="corrected")
    assert box.peak > 5e-4  # of how it moves see tests/scene/containers/test_box_in_time.py
    np.testing.assert_allclose(box.displacement[:, :4], 0.0, atol=1e-12)


@pytest.mark.parametrize("height", ["one-mode", "corrected"])
def test_place_heading_and_sign_of_the_quaternion_do_not_matter(height: str) -> None:
    t = clock(1.5)
    position = along_x(0.4 * quintic(t, 0.8))
    position[:, 1] = 0.1 * quintic(t, 0.6)
    lean = Rotation.from_rotvec(np.outer(0.3 * quintic(t, 0.7), [0.3, 1.0, 0.2]))
    plain = simulate_slosh(CUP, t, position, lean.as_quat(), height=height)
    turn = Rotation.from_euler("z", 1.1)
    turned = simulate_slosh(
        CUP, t, turn.apply(position) + np.array([3.0, -2.0, 1.0]), -(turn * lean).as_quat(), height=height
    )
    assert turned.height == pytest.approx(plain.height, abs=1e-8)


def test_steady_acceleration_is_a_steady_slope() -> None:
    # A liquid that is lifted into acceleration slowly ends on the slope a/g; both heights are known.
    t = clock(9.0)
    acceleration = 2.0 * quintic(t, 6.0)
    speed = np.concatenate([[0.0], np.cumsum((acceleration[1:] + acceleration[:-1]) / 2 / RATE)])
    x = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 / RATE)])
    slope = RADIUS * 2.0 / STANDARD_GRAVITY
    assert simulate_translation(x, t, height="corrected").height[-500:] == pytest.approx(slope, rel=5e-3)
    one = simulate_translation(x, t, modes=1).height[-500:]
    assert one == pytest.approx(slope * 2 / (FIRST_ROOT**2 - 1), rel=5e-3)


def test_small_swings_are_the_linear_oscillator() -> None:
    # Shaken near resonance so little that the paraboloid is flat, the mode is x'' + 2 z w x' + w^2 x = -a.
    cup = {**CUP, "damping": "0.02"}
    depth = FIRST_ROOT * 0.080 / RADIUS
    frequency = np.sqrt(STANDARD_GRAVITY * FIRST_ROOT / RADIUS * np.tanh(depth))
    gain = 2 * FIRST_ROOT * np.tanh(depth) / (FIRST_ROOT**2 - 1)
    drive, amplitude = 0.98 * frequency, 2e-5
    t = clock(4.0)
    x = amplitude * (np.sin(drive * t) - drive * t)

    def rate(time: float, state: np.ndarray) -> list[float]:
        force = amplitude * drive**2 * np.sin(drive * time)
        return [state[1], force - 0.04 * frequency * state[1] - frequency**2 * state[0]]

    exact = solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-15)
    found = simulate_translation(x, t, cup, modes=1)
    largest = gain * np.max(np.abs(exact.y[0]))
    assert largest > 10 * amplitude
    assert found.height == pytest.approx(gain * np.abs(exact.y[0]), abs=2e-3 * largest)


def test_tilting_with_the_apparent_gravity_about_the_modal_height_leaves_the_mode_at_rest() -> None:
    # The point at H_1 moves along x; the axis follows a + g; then the first mode feels no lateral force.
    t = clock(1.6)
    u = t / 1.6
    acceleration = 1.5 * (60 * u - 180 * u**2 + 120 * u**3) / 6
    path = 1.5 * 1.6**2 / 6 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    wave = FIRST_ROOT / RADIUS
    modal_height = 0.080 - 2 / wave * np.tanh(wave * 0.080 / 2)
    lean = np.arctan2(acceleration, STANDARD_GRAVITY)
    attitude = Rotation.from_euler("y", lean[:, None])
    bottom = along_x(path) - attitude.apply([0.0, 0.0, modal_height])
    found = simulate_slosh(CUP, t, bottom, attitude.as_quat(), modes=1)
    level = simulate_translation(path, t)
    # At both ends the jerk jumps and with it the turning rate, which the spline rounds off.
    assert np.max(np.abs(found.displacement)) < 2e-5
    assert level.peak > 5e-3


def test_less_gravity_lengthens_the_swing() -> None:
    t = clock(6.0)
    x = 0.001 * quintic(t, 0.3)  # small: the paraboloid makes large swings slower
    zeros = []
    for gravity in (9.80665, 9.80665 / 4):
        found = simulate_slosh({**CUP, "damping": "0.001"}, t, along_x(x), upright(t), gravity=gravity)
        free = found.displacement[t > 0.5, 0]
        crossings = np.flatnonzero(np.diff(np.sign(free)))
        zeros.append((crossings[-1] - crossings[0]) / (len(crossings) - 1))
    assert zeros[1] / zeros[0] == pytest.approx(2.0, rel=2e-2)


def test_rounded_samples_give_the_height_of_exact_ones() -> None:
    t = clock(2.0)
    x = 0.4 * quintic(t, 1.0)
    exact = simulate_translation(x, t, height="corrected")
    rounded = simulate_translation(np.round(x, 6), t, height="corrected")
    assert np.max(np.abs(rounded.height - exact.height)) < 5e-5
    coarse = simulate_translation(x[::5], t[::5], height="corrected")
    assert coarse.height == pytest.approx(exact.height[::5], abs=2e-4)


def test_an_uneven_clock_gives_the_same_height() -> None:
    t = clock(1.5)
    jitter = np.random.default_rng(3).uniform(-2e-4, 2e-4, len(t))
    uneven = t + jitter * (np.arange(len(t)) > 0)
    plain = simulate_translation(0.3 * quintic(t, 0.9), t)
    found = simulate_translation(0.3 * quintic(uneven, 0.9), uneven)
    # Where the mode swings through zero the height has a kink, which interpolation rounds off.
    assert np.interp(t, uneven, found.height) == pytest.approx(plain.height, abs=5e-5)


def test_a_scene_and_a_table_and_a_file_are_the_same_cup(tmp_path: Path) -> None:
    cargo = ns.load("matrix-liquid").cargo[0]
    table = {"shape": "cylinder", "radius": "35 mm", "height": "99.1 mm", "liquid": "water", "liquid_height": "49 mm"}
    file = tmp_path / "cup.toml"
    file.write_text("".join(f'{key} = "{value}"\n' for key, value in table.items()))
    t = clock(1.0)
    motion = (t, along_x(0.2 * quintic(t, 0.7)), upright(t))
    first = ns.simulate_slosh(cargo, *motion, modes=3)
    assert first.displacement.shape == (len(t), 6)
    for cup in (table, file, str(file)):
        assert np.array_equal(ns.simulate_slosh(cup, *motion, modes=3).height, first.height)


def test_the_void_model_is_an_error() -> None:
    t = clock(0.5)
    fall = np.column_stack([0 * t, 0 * t, -0.5 * 12.0 * t**2])
    with pytest.raises(ModelError, match=r"apparent gravity along the container's axis is -2.19 m/s\^2.*void"):
        simulate_slosh(CUP, t, fall, upright(t))
    upside_down = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
    with pytest.raises(ModelError, match="does not press the liquid into its container"):
        simulate_slosh(CUP, t, np.zeros((len(t), 3)), upside_down)


def test_jumps_and_wrong_units_are_no_motion() -> None:
    t = clock(0.5)
    for x in (np.where(t > 0.25, 0.3, 0.0), 300.0 * quintic(t, 0.4)):
        with pytest.raises(ScenarioError, match=r"is accelerated by .* give positions in metres and without jumps"):
            simulate_translation(x, t)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"radius": "4 bananas"}, "radius .*bananas"),
        ({"radus": "49 mm"}, 'unknown key "radus"'),
        ({"liquid_height": "180 mm"}, "above the rim"),
        ({"liquid": "lava"}, 'liquid "lava" is unknown'),
        ({"liquid": None}, "liquid is missing|liquid_height is given but liquid is not"),
        ({"shape": "sphere"}, "shape .*sphere"),
        ({"shape": None}, "shape is missing"),
    ],
)
def test_cups_that_cannot_be(change: dict[str, str | None], message: str) -> None:
    table = {key: value for key, value in {**CUP, **change}.items() if value is not None}
    t = clock(0.1)
    with pytest.raises(ScenarioError, match=message) as caught:
        simulate_slosh(table, t, np.zeros((len(t), 3)), upright(t))
    assert "\n" not in str(caught.value)


def test_options_that_cannot_be() -> None:
    t = clock(0.1)
    motion = (t, np.zeros((len(t), 3)), upright(t))
    for modes in (0, 21, 1.5, True):
        with pytest.raises(ScenarioError, match="a whole number from 1 to 20"):
            simulate_slosh(CUP, *motion, modes=modes)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match='"one-mode" or "corrected"'):
        simulate_slosh(CUP, *motion, height="tall")
    slow = np.arange(10) * 0.1
    with pytest.raises(ScenarioError, match=r"samples are 0\.1 s apart"):
        simulate_slosh(CUP, slow, np.zeros((10, 3)), upright(slow))


def test_the_contact_line_stays_behind_by_half_and_then_by_most_of_a_capillary_length() -> None:
    t = clock(1.2)
    x = 0.2 * quintic(t, 0.6)
    surface, line = simulate_translation(x, t, modes=20), simulate_translation(x, t, model="contact-line")
    assert np.array_equal(line.height, surface.height)  # the same modes, and spilling is about the surface
    assert np.array_equal(surface.reading, surface.height)
    water = 0.9 * np.sqrt(0.0728 / (998.0 * STANDARD_GRAVITY))
    behind = surface.height - line.reading
    assert np.max(behind) == pytest.approx(water, rel=0.01) and np.max(surface.height) > 0.01
    low = surface.height < 2.0 * np.max(behind)
    assert behind[low] == pytest.approx(0.5 * surface.height[low])
    # A gauge at one place reads falls as it reads rises.
    front, back = (simulate_translation(x, t, model="contact-line", azimuth=angle) for angle in (0.0, np.pi))
    assert front.reading == pytest.approx(-back.reading, abs=1e-9)
    with pytest.raises(ScenarioError, match='"surface" or "contact-line"'):
        simulate_translation(x, t, model="camera")


def write_case(folder: Path) -> tuple[Path, Path]:
    cup, motion = folder / "cup.toml", folder / "motion.csv"
    cup.write_text("".join(f'{key} = "{value}"\n' for key, value in CUP.items()))
    t = clock(1.0)
    x = 0.2 * quintic(t, 0.8)
    rows = "".join(f"{a:.3f},{b:.9f},0,0,0,0,0,1\n" for a, b in zip(t, x, strict=True))
    motion.write_text("t_s,x_m,y_m,z_m,qx,qy,qz,qw\n" + rows)
    return cup, motion


def test_command_prints_the_peak_and_writes_the_heights(tmp_path: Path) -> None:
    cup, motion = write_case(tmp_path)
    plain = CliRunner().invoke(app, ["simulate", str(cup), str(motion)])
    assert plain.exit_code == 0 and "peak height: " in plain.stdout and " mm above rest at t = " in plain.stdout
    out = tmp_path / "out.csv"
    kept = CliRunner().invoke(app, ["simulate", str(cup), str(motion), "-o", str(out), "--modes", "2"])
    assert kept.exit_code == 0
    # Two modes are the default, in both ways to ask.
    assert kept.stdout.splitlines()[0] == plain.stdout.splitlines()[0]
    one = CliRunner().invoke(app, ["simulate", str(cup), str(motion), "--modes", "1"])
    assert one.exit_code == 0 and one.stdout != plain.stdout
    given = read_motion(motion)
    found = simulate_slosh(cup, given.t, given.position, given.quaternion)
    assert read_heights(out).height == pytest.approx(found.height, abs=1e-7)
    lines = out.read_text().splitlines()
    assert lines[0] == "t_s,height_mm" and len(lines) == 502
    line = CliRunner().invoke(app, ["simulate", str(cup), str(motion), "-o", str(out), "--model", "contact-line"])
    assert line.exit_code == 0 and "peak of the contact line: " in line.stdout
    read = simulate_slosh(cup, given.t, given.position, given.quaternion, model="contact-line").reading
    assert read_heights(out).height == pytest.approx(read, abs=1e-7)
    corrected = CliRunner().invoke(app, ["simulate", str(cup), str(motion), "--height", "corrected"])
    assert corrected.exit_code == 0 and corrected.stdout != plain.stdout


def test_command_says_what_is_wrong_in_one_line(tmp_path: Path) -> None:
    cup, motion = write_case(tmp_path)
    broken = tmp_path / "broken.csv"
    lines = motion.read_text().splitlines()
    broken.write_text("\n".join(lines[:100] + lines[110:]))
    for arguments in ([str(cup), str(broken)], [str(cup), "absent.csv"], ["absent.toml", str(motion)]):
        result = CliRunner().invoke(app, ["simulate", *arguments])
        assert result.exit_code == 2 and result.stderr.count("\n") == 1 and not result.stdout
