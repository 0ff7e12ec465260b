"""File formats for robot controllers, one file a format, in one table."""

from __future__ import annotations

from nospill.export.action_goal import ACTION_GOAL
from nospill.export.base import Exporter as Exporter
from nospill.export.joint_csv import CSV
from nospill.export.joint_trajectory import JOINT_TRAJECTORY
from nospill.export.lab_csv import LAB_CSV
from nospill.export.mat import MAT
from nospill.export.rosbag2 import ROSBAG2
from nospill.export.tray_csv import TRAY_CSV
from nospill.export.urscript import URSCRIPT

EXPORTERS: dict[str, Exporter] = {
    exporter.name: exporter
    for exporter in (LAB_CSV, CSV, JOINT_TRAJECTORY, ACTION_GOAL, ROSBAG2, URSCRIPT, TRAY_CSV, MAT)
}
"""Every file format a plan can be written in."""
