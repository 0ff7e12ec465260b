"""A folder of runs compared at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.simulation.motion_file import Heights, write_heights
from nospill.simulation.runs import compare_runs
from nospill.simulation.simulate import simulate_slosh
from tests.measured import measured_data

CUP = 'shape = "cylinder"\nradius = "49 mm"\nheight = "150 mm"\nliquid = "water"\nliquid_height = "80 mm"\n'
TOLERANCE = '[tolerance]\nliquid_height = "5 mm"\ndamping = [0.5, 3.0]\n'
TABLE = {"shape": "cylinder", "radius": 0.049, "height": 0.15, "liquid": "water", "liquid_height": 0.08}


def motion(length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half a metre along x in so many s, with rest before and after."""
    t = np.arange(0.0, length + 1.5, 0.002)
    u = np.clip((t - 0.5) / length, 0.0, 1.0)
    position = np.zeros((len(t), 3))
    position[:, 0] = 0.5 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    return t, position, np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two runs whose measured heights are those of a fuller container with more damping, and its description."""
    for name, length in (("quick", 0.9), ("slow", 1.3)):
        t, position, quaternion = motion(length)
        rows = np.column_stack([t, position, quaternion])
        np.savetxt(
            tmp_path / f"{name}.motion.csv", rows, delimiter=",", header="t_s,x_m,y_m,z_m,qx,qy,qz,qw", comments=""
        )
        seen = simulate_slosh({**TABLE, "liquid_height": 0.083, "damping": 0.01}, t, position, quaternion)
        write_heights(tmp_path / f"{name}.height.csv", Heights(seen.t[::8] + 4.0, seen.height[::8]))
    (tmp_path / "cup.toml").write_text(CUP + TOLERANCE, encoding="utf-8")
    (tmp_path / "exact.toml").write_text(CUP, encoding="utf-8")
    return tmp_path


def test_every_run_is_compared_and_its_band_holds_what_the_tolerance_allows(folder: Path) -> None:
    runs = compare_runs(folder, folder / "cup.toml")
    assert [run.name for run in runs] == ["quick", "slow"]
    for run in runs:
        assert run.comparison.shift == pytest.approx(4.0, abs=0.02)
        assert run.comparison.correlation > 0.99
        assert np.all(run.low <= run.comparison.predicted)
        assert np.all(run.comparison.predicted <= run.high)
        assert np.max(run.high - run.low) > 1e-4


def test_without_a_tolerance_the_band_is_the_prediction(folder: Path) -> None:
    run = compare_runs(folder, folder / "exact.toml")[0]
    assert np.array_equal(run.low, run.high)


def test_heights_at_an_azimuth_have_signs(folder: Path) -> None:
    t, position, quaternion = motion(0.9)
    crest = simulate_slosh(TABLE, t, position, quaternion)
    along, across, behind = (
        simulate_slosh(TABLE, t, position, quaternion, azimuth=angle) for angle in (0.0, np.pi / 2, np.pi)
    )
    assert np.max(np.abs(np.abs(along.height) - crest.height)) < 1e-9
    assert along.height[np.argmax(crest.height[t < 0.8])] < 0.0  # the surface falls in front of an accelerated wall
    assert np.max(np.abs(across.height)) < 1e-9
    assert behind.height == pytest.approx(-along.height)
    write_heights(folder / "quick.height.csv", Heights(along.t[::8], along.height[::8]))
    signed = compare_runs(folder, folder / "exact.toml", azimuth=0.0)[0].comparison
    assert signed.correlation == pytest.approx(1.0, abs=1e-3)
    assert np.min(signed.measured) < -0.001
    turned = compare_runs(folder, folder / "exact.toml", azimuth=np.pi)[0].comparison
    assert turned.correlation < 0.95


@pytest.mark.parametrize(
    ("gone", "message"),
    [
        ("slow.height.csv", "slow.height.csv is missing beside slow.motion.csv"),
        ("*.motion.csv", "no runs: NAME.motion"),
    ],
)
def test_a_folder_without_pairs_is_refused(folder: Path, gone: str, message: str) -> None:
    for path in folder.glob(gone):
        path.unlink()
    with pytest.raises(ScenarioError, match=message):
        compare_runs(folder, folder / "cup.toml")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["compare", *arguments])


def test_the_command_prints_a_table_and_draws(folder: Path) -> None:
    figure = folder / "runs.png"
    result = run(str(folder), "--cup", str(folder / "cup.toml"), "-o", str(figure))
    assert result.exit_code == 0, result.output
    for phrase in ("quick", "slow", "within band", "medians of 2 runs: |peak error|"):
        assert phrase in result.output, phrase
    assert figure.stat().st_size > 10_000


def test_the_command_wants_a_cup_or_a_measurement(folder: Path) -> None:
    for arguments in (
        [str(folder)],
        [str(folder), str(folder / "quick.height.csv"), "--cup", str(folder / "cup.toml")],
    ):
        result = run(*arguments)
        assert result.exit_code == 2
        assert "give MEASURED.csv beside one prediction, or --cup CUP.toml beside a folder of runs" in result.output


def test_runs_are_compared_with_what_a_gauge_at_the_wall_reads(folder: Path) -> None:
    surface, line = (
        compare_runs(folder, folder / "exact.toml", modes=3, model=model)[0].comparison
        for model in ("surface", "contact-line")
    )
    assert surface.predicted_peak - line.predicted_peak == pytest.approx(2.46e-3, abs=2e-5)
    result = run(str(folder), "--cup", str(folder / "exact.toml"), "--model", "gauge")
    assert result.exit_code == 2 and '"surface" or "contact-line" is needed' in result.output


@pytest.mark.oracle
@pytest.mark.slow
def test_runs_of_the_laboratory(tmp_path: Path) -> None:
    (tmp_path / "cup.toml").write_text(CUP, encoding="utf-8")
    runs = compare_runs(measured_data("slosh-runs"), tmp_path / "cup.toml")
    assert len(runs) == 21
    assert np.median([abs(own.comparison.relative_peak_error) for own in runs]) < 0.06
    assert np.median([own.comparison.correlation for own in runs]) > 0.94
