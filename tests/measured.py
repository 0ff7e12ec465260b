"""The folder of measured and published data, which not everybody has."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.slosh.validate import data_folder


def measured_data(name: str = "") -> Path:
    """A file or folder of measured and published data, where NOSPILL_DATA says; the test skips without it."""
    place = data_folder() / name
    if not place.exists():
        pytest.skip(f"measured data are not here: {place}; NOSPILL_DATA names their folder")
    return place
