"""nospill: the fastest motion of a robot arm that carries open cups and loose objects on a tray, with a certificate.

import nospill as ns
scene = ns.load("matrix-liquid")
plan = ns.plan(scene)
plan.duration, plan.certificate.ok, plan.trajectory(1.2)
plan.save("out")
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from nospill.errors import Change as Change
from nospill.errors import MissingExtraError as MissingExtraError
from nospill.errors import ModelError as ModelError
from nospill.errors import NoSolutionError as NoSolutionError
from nospill.errors import NospillError as NospillError
from nospill.errors import PlanFolderError as PlanFolderError
from nospill.errors import ScenarioError as ScenarioError

if TYPE_CHECKING:
    from nospill.judge.certificate import certify as certify
    from nospill.judge.certificate import certify_joints as certify_joints
    from nospill.judge.histories import ContactLoad as ContactLoad
    from nospill.judge.histories import History as History
    from nospill.judge.histories import ModalStates as ModalStates
    from nospill.judge.verdict import Certificate as Certificate
    from nospill.motion.trajectory import Trajectory as Trajectory
    from nospill.planning.planner import Planner as Planner
    from nospill.planning.planner import plan as plan
    from nospill.plans.loading import load_plan as load_plan
    from nospill.plans.plan import Plan as Plan
    from nospill.plans.rows import starting_after as starting_after
    from nospill.scenario import load as load
    from nospill.scene.scene import Scene as Scene
    from nospill.simulation.simulate import simulate_slosh as simulate_slosh

__version__ = "0.2.0"

_PLACES = {
    "Certificate": ("nospill.judge.verdict", "Certificate"),
    "certify": ("nospill.judge.certificate", "certify"),
    "certify_joints": ("nospill.judge.certificate", "certify_joints"),
    "ContactLoad": ("nospill.judge.histories", "ContactLoad"),
    "History": ("nospill.judge.histories", "History"),
    "ModalStates": ("nospill.judge.histories", "ModalStates"),
    "Plan": ("nospill.plans.plan", "Plan"),
    "load_plan": ("nospill.plans.loading", "load_plan"),
    "Planner": ("nospill.planning.planner", "Planner"),
    "plan": ("nospill.planning.planner", "plan"),
    "load": ("nospill.scenario", "load"),
    "Scene": ("nospill.scene.scene", "Scene"),
    "starting_after": ("nospill.plans.rows", "starting_after"),
    "simulate_slosh": ("nospill.simulation.simulate", "simulate_slosh"),
    "Trajectory": ("nospill.motion.trajectory", "Trajectory"),
}
"""Public name -> module and name there. Imported at first use, so that reading a scenario needs no optimiser."""

__all__ = [
    "Certificate",
    "Change",
    "ContactLoad",
    "History",
    "MissingExtraError",
    "ModalStates",
    "ModelError",
    "NoSolutionError",
    "NospillError",
    "Plan",
    "PlanFolderError",
    "Planner",
    "ScenarioError",
    "Scene",
    "Trajectory",
    "certify",
    "certify_joints",
    "load",
    "load_plan",
    "plan",
    "simulate_slosh",
    "starting_after",
]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'nospill' has no attribute {name!r}")
    module, attribute = _PLACES[name]
    value = getattr(importlib.import_module(module), attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
