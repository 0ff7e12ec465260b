"""File formats for robot controllers, one file a format, in one table."""

from __future__ import annotations

from nospill.export.base import Exporter as Exporter
from nospill.export.lab_csv import LAB_CSV

EXPORTERS: dict[str, Exporter] = {exporter.name: exporter for exporter in (LAB_CSV,)}
"""Every file format a plan can be written in."""
