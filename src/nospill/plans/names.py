"""Names of the files in a plan folder, and whether a folder is one."""

from __future__ import annotations

from nospill.export import EXPORTERS

SCENARIO_FILE = "scenario.toml"
TRAJECTORY_FILE = "trajectory.csv"
APPROACH_FILE = "approach.csv"
CERTIFICATE_FILE = "certificate.json"
SUMMARY_FILE = "summary.json"
FIGURES_FOLDER = "figures"
STOPS_FILE, STOPS_FIGURE, STOPS_FOLDER = "stops.json", "stops.png", "stops"
CYCLE_FILE = "cycle.json"
LEGS_FOLDER = "legs"

_CONTROLLER_FILES = {exporter.plan_file for exporter in EXPORTERS.values() if exporter.plan_file is not None}
PLAN_NAMES = frozenset(
    {
        SCENARIO_FILE,
        TRAJECTORY_FILE,
        APPROACH_FILE,
        CERTIFICATE_FILE,
        SUMMARY_FILE,
        FIGURES_FOLDER,
        STOPS_FILE,
        STOPS_FIGURE,
        STOPS_FOLDER,
        *_CONTROLLER_FILES,
    }
)
"""What a plan folder may hold; stops go with the plan that they are of."""


def is_plan_folder(names: set[str]) -> bool:
    """Whether a folder with these names in it was written as a plan: it holds the summary and nothing foreign."""
    return SUMMARY_FILE in names and names <= PLAN_NAMES


CYCLE_NAMES = frozenset({SCENARIO_FILE, CERTIFICATE_FILE, CYCLE_FILE, LEGS_FOLDER, FIGURES_FOLDER})
"""What the folder of a planned cycle may hold."""


def is_cycle_folder(names: set[str]) -> bool:
    """Whether a folder with these names in it was written as the plan of a cycle, and holds nothing foreign."""
    return CYCLE_FILE in names and names <= CYCLE_NAMES


def holds_a_plan(names: set[str]) -> bool:
    """Whether a folder with these names in it was written as the plan of a motion or of a cycle."""
    return is_plan_folder(names) or is_cycle_folder(names)
