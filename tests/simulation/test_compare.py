"""Predicted beside measured heights: clocks, figures, plan folders, the command and its figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import nospill.simulation.compare
from nospill.cli import app
from nospill.errors import PlanFolderError, ScenarioError
from nospill.simulation.compare import compare, predicted_heights
from nospill.simulation.motion_file import Heights, write_heights


def wave(t: np.ndarray) -> np.ndarray:
    """A swing with a beginning and an end, m, of both signs; zero outside 0 to 3 s."""
    inside = (t > 0.0) & (t < 3.0)
    return np.where(inside, 0.02 * np.sin(np.pi * t / 3.0) ** 2 * np.sin(2 * np.pi * 1.7 * t + 2.0 * t**2), 0.0)


def prediction() -> Heights:
    t = np.arange(0.0, 4.0, 0.002)
    return Heights(t, np.abs(wave(t - 0.5)))


def measurement(shift: float, *, noise: float = 0.0, scale: float = 1.0, seed: int = 0, first: float = 0.0) -> Heights:
    t = first + np.arange(0.0, 20.0, 1 / 60)
    height = scale * wave(t - 0.5 - shift) + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Heights(t, height)


@settings(deadline=None, max_examples=25)
@given(st.floats(0.0, 12.0), st.integers(0, 1000))
def test_a_known_shift_is_found_to_a_millisecond_under_noise(shift: float, seed: int) -> None:
    found = compare(prediction(), measurement(shift, noise=3e-4, seed=seed))
    assert found.shift == pytest.approx(shift, abs=1e-3)
    assert found.correlation > 0.99


def test_a_noisy_camera_costs_milliseconds() -> None:
    # The Cramer-Rao bound for 1 mm at 60 Hz on this wave is 0.4 ms.
    shifts = [compare(prediction(), measurement(4.75, noise=1e-3, seed=seed)).shift for seed in range(40)]
    assert np.mean(shifts) == pytest.approx(4.75, abs=5e-4) and np.std(shifts) < 1e-3


def test_the_same_curve_agrees_with_itself() -> None:
    found = compare(prediction(), prediction())
    assert found.shift == pytest.approx(0.0, abs=1e-6)
    assert found.correlation == pytest.approx(1.0) and found.rmse < 1e-6
    assert found.peak_error == pytest.approx(0.0, abs=1e-6) and found.integral_error == pytest.approx(0.0, abs=1e-4)


def test_a_measurement_that_begins_late_and_clocks_that_begin_anywhere() -> None:
    whole = measurement(2.0)
    cut = Heights(whole.t[whole.t > 2.2] + 100.0, whole.height[whole.t > 2.2])
    assert compare(prediction(), cut).shift == pytest.approx(102.0, abs=1e-3)
    moved = Heights(prediction().t - 7.0, prediction().height)
    assert compare(moved, measurement(2.0)).shift == pytest.approx(9.0, abs=1e-3)


@pytest.mark.parametrize("scale", [0.5, 1.25])
def test_figures_of_a_scaled_measurement(scale: float) -> None:
    found = compare(prediction(), measurement(3.0, scale=scale))
    assert found.relative_peak_error == pytest.approx(1 / scale - 1, abs=0.02)
    assert found.integral_error == pytest.approx(1 / scale - 1, abs=0.01)
    assert found.peak_error == pytest.approx(found.predicted_peak - found.measured_peak)
    square = np.mean(prediction().height ** 2)
    assert found.rmse == pytest.approx(abs(1 - scale) * np.sqrt(square), rel=0.02)
    assert found.correlation == pytest.approx(1.0, abs=1e-3)


def test_the_search_is_pearsons_correlation_at_every_lag() -> None:
    random = np.random.default_rng(1)
    ours, theirs = random.standard_normal(40), random.standard_normal(70)
    lags, values = nospill.simulation.compare._normalised_correlation(ours, theirs)
    assert lags[0] == -8 and lags[-1] == 38  # 80 % of 40 samples in common
    for lag, value in zip(lags, values, strict=True):
        low, high = max(0, -lag), min(40, 70 - lag)
        assert value == pytest.approx(np.corrcoef(ours[low:high], theirs[low + lag : high + lag])[0, 1], abs=1e-10)


def test_a_height_that_never_changes_is_refused() -> None:
    flat = Heights(np.arange(0.0, 5.0, 0.01), np.zeros(500))
    with pytest.raises(ScenarioError, match="predicted: the height never changes"):
        compare(flat, measurement(1.0))
    with pytest.raises(ScenarioError, match="measured: the height never changes"):
        compare(prediction(), flat)
    with pytest.raises(ScenarioError, match="too long to be aligned"):
        compare(prediction(), Heights(np.array([0.0, 1e6]), np.array([0.0, 1.0])))


def test_a_plan_folder_needs_a_cup(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="is a folder; for a plan add the cup's name"):
        predicted_heights(tmp_path)
    with pytest.raises(PlanFolderError, match="not a plan folder"):
        predicted_heights(f"{tmp_path}:c1")
    with pytest.raises(ScenarioError, match="does not exist"):
        predicted_heights(tmp_path / "absent:c1")


def test_a_plan_gives_its_cups_planned_height(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from types import SimpleNamespace

    t = np.arange(0.0, 1.0, 0.01)
    trajectory = SimpleNamespace(t=t, slosh={"c1": SimpleNamespace(height=0.01 * t)})
    monkeypatch.setattr(nospill.simulation.compare, "load_plan", lambda folder: SimpleNamespace(trajectory=trajectory))
    assert np.array_equal(predicted_heights(f"{tmp_path}:c1").height, 0.01 * t)
    with pytest.raises(ScenarioError, match=r'no cup "c9" with a liquid; choose .*c1'):
        predicted_heights(f"{tmp_path}:c9")


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_command_prints_the_figures_and_draws(tmp_path: Path, ending: str) -> None:
    predicted, measured, figure = tmp_path / "p.csv", tmp_path / "m.csv", tmp_path / f"both.{ending}"
    write_heights(predicted, prediction())
    write_heights(measured, measurement(3.0, noise=5e-4))
    result = CliRunner().invoke(app, ["compare", str(predicted), str(measured), "-o", str(figure)])
    assert result.exit_code == 0, result.stderr
    for words in ("peak error", "root mean square error", "correlation", "integral error", "clock shift"):
        assert words in result.stdout
    start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[ending]
    assert figure.read_bytes().startswith(start)


def test_command_says_what_is_wrong_in_one_line(tmp_path: Path) -> None:
    heights = tmp_path / "p.csv"
    write_heights(heights, prediction())
    for arguments, words in (
        ([str(heights), "absent.csv"], "does not exist"),
        (["absent.csv", str(heights)], "does not exist"),
        ([str(heights), str(heights), "-o", "figure.xyz"], ".png, .pdf or .svg"),
        ([str(heights), str(heights), "-o", str(tmp_path / "absent" / "f.png")], "cannot write"),
    ):
        result = CliRunner().invoke(app, ["compare", *arguments])
        assert result.exit_code == 2 and words in result.stderr and result.stderr.count("\n") == 1, result.output
