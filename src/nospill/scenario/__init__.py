"""The only reader and writer of scenario files."""

from nospill.scenario.loading import load as load
from nospill.scenario.loading import read_scenario as read_scenario
from nospill.scenario.scenes import scenario_schema as scenario_schema
from nospill.scenario.scenes import scene_from_table as scene_from_table
