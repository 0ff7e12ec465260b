"""A small scene of cup, box and bottle, and judged motions of scenes that no solver is asked for."""

from __future__ import annotations

from nospill.certification.certificate import Judgement, judge
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record

LONG = "a-cup-with-a-name-of-sixty-four-letters-which-is-the-most-allowed"[:64]


def cup(name: str, x: int, y: int) -> dict[str, object]:
    size = {"shape": "cylinder", "radius": "25 mm", "height": "99 mm"}
    filling = {"liquid": "water", "liquid_height": "49 mm", "max_slosh_height": f"{12 + abs(x) // 10} mm"}
    return {"name": name, "at": [f"{x} mm", f"{y} mm"], **size, **filling}


def table(cargo: list[dict[str, object]], **motion: object) -> dict[str, object]:
    return {
        "fidelity": "full",
        "name": "small-plan",
        "robot": {"model": "comau-smart-six"},
        "tray": {"size": ["335 mm", "250 mm"], "friction": 0.466, "friction_reserve": 0.1, "offset": "108 mm"},
        "cargo": cargo,
        "path": {"type": "preset", "name": "arc", "yaw": ["0 deg", "90 deg"]},
        "motion": {"end": "residual", **motion},
        "planning": {"slosh_modes": 1},
    }


CARGO: list[dict[str, object]] = [
    cup("cup", -100, -60) | {"empty_mass": "30 g"},
    {
        "name": "box",
        "at": ["70 mm", "-60 mm"],
        "shape": "box",
        "length": "80 mm",
        "width": "60 mm",
        "height": "90 mm",
        "liquid": "water",
        "liquid_height": "45 mm",
        "max_slosh_height": "20 mm",
        "empty_mass": "40 g",
    },
    {
        "name": "bottle",
        "at": ["80 mm", "60 mm"],
        "shape": "cylinder",
        "radius": "33 mm",
        "height": "120 mm",
        "mass": "0.4 kg",
    },
]


def plan_of(scene: Scene, stretch: float) -> tuple[Plan, Judgement]:
    """A smooth motion along the path, judged; no solver is involved, so the limits may or may not hold."""
    path = joint_path_of(scene, samples=41)
    start = Start(stretch=stretch, skew=0.2, tilt=(-0.1, 0.05) if scene.motion.tilt_free else (0.0, 0.0))
    trajectory = smooth_record(scene, path, 40, start)
    judgement = judge(trajectory, scene)
    report = PlanningReport.empty()
    return Plan(scene, trajectory, judgement.certificate, motion_maxima(judgement, scene), report), judgement
