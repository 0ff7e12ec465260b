"""Logs as makers' own software names their columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nospill.execution.reading import read_log
from nospill.robots.description.catalog import load_robot

ROWS = range(60)


def test_libfrankas_own_log_has_positions_commands_and_a_clock_in_ms(tmp_path: Path) -> None:
    names = [f"state.{what}[{index}]" for what in ("q", "q_d", "dq") for index in range(7)]
    lines = [",".join(map(str, (k, 1, *(0.1 * i + 1e-3 * k for i in range(21))))) for k in ROWS]
    (tmp_path / "log.csv").write_text("\n".join([",".join(("time", "success_rate", *names)), *lines]))
    log = read_log(tmp_path / "log.csv", load_robot("franka-fr3"))
    assert log.command is not None
    np.testing.assert_allclose(log.t[:3], [0.0, 1e-3, 2e-3])
    np.testing.assert_allclose(log.position[0], 0.1 * np.arange(7))
    np.testing.assert_allclose(log.command[0], 0.7 + 0.1 * np.arange(7))


def test_a_log_of_rsi_is_told_by_its_axes(tmp_path: Path) -> None:
    names = ";".join(("IPOC", *(f"AIPos.A{index}" for index in range(1, 7))))
    lines = [";".join(map(str, (1000 + 4 * k, *(10.0 + i + 0.01 * k for i in range(6))))) for k in ROWS]
    (tmp_path / "rsi.csv").write_text("\n".join([names, *lines]))
    log = read_log(tmp_path / "rsi.csv", load_robot("kuka-kr6-r900"), unit="deg")
    np.testing.assert_allclose(np.degrees(log.position[0]), 10.0 + np.arange(6))
    np.testing.assert_allclose(np.diff(log.t), 4e-3)
