"""Films of smooth motions, which need no solver."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from nospill.certification.certificate import judge
from nospill.drawing.timeline import Film, make_film
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.scenario import scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record, with_few_speeds

UNLIKE = tuple(
    name
    for name in EXAMPLES
    if not name.startswith("matrix-liquid-") or name == "matrix-liquid-tilt-all-limits"  # the longest of these names
)
"""Examples whose objects have other names or places than those of matrix-liquid; that, level; and that, tilting."""


def film_of(scene: Scene, *, rate: float = 30.0, stretch: float = 1.0) -> Film:
    """A smooth motion along the path of a scene, judged and cut; its limits may or may not hold."""
    path = joint_path_of(scene)
    start = Start(stretch=stretch, skew=0.2, tilt=(-0.15, 0.1) if scene.motion.tilt_free else (0.0, 0.0))
    trajectory = smooth_record(scene, path, 200, start)
    judgement = judge(trajectory, scene)
    report = PlanningReport.empty()
    plan = Plan(scene, trajectory, judgement.certificate, motion_maxima(judgement, scene), report)
    return make_film(plan, judgement, rate=rate, length=plan.duration + 0.3)


@pytest.fixture(scope="session")
def tilting_film(changed_scene: Callable[..., Scene]) -> Film:
    """matrix-liquid-tilt: four cups on a tray that tilts, full fidelity, one mode."""
    return film_of(changed_scene("matrix-liquid-tilt", {"planning.slosh_modes": 1}))


@pytest.fixture(scope="session")
def level_film(changed_scene: Callable[..., Scene]) -> Film:
    """matrix-liquid: the same cups on a level tray, the published physics."""
    return film_of(changed_scene("matrix-liquid", {}))


@pytest.fixture(scope="session")
def example_film(changed_scene: Callable[..., Scene]) -> Callable[[str], Film]:
    """A smooth motion of an example with one mode of each liquid, three pictures a second; made once for all tests."""
    return cache(lambda name: film_of(changed_scene(name, {"planning.slosh_modes": 1}), rate=3.0))


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory, tilting_film: Film, level_film: Film) -> tuple[str, str]:
    """Plan folders of the level and of the tilting motion."""
    place = tmp_path_factory.mktemp("plans")
    for name, film in (("level", level_film), ("tilting", tilting_film)):
        with_few_speeds(film.plan).save(place / name)
    return str(place / "level"), str(place / "tilting")


@pytest.fixture(scope="session")
def mixed_film() -> Film:
    """A turned box with liquid, a cup and a solid on a tray that is turned on the flange and off its axis; 2 modes."""
    cup: dict[str, Any] = {"liquid": "water", "max_slosh_height": "20 mm"}
    table: dict[str, Any] = {
        "fidelity": "full",
        "name": "mixed",
        "robot": {"model": "comau-smart-six"},
        "tray": {
            "size": ["335 mm", "250 mm"],
            "friction": 0.466,
            "offset": ["10 mm", "-5 mm", "108 mm"],
            "yaw_on_flange": "20 deg",
        },
        "cargo": [
            cup
            | {
                "name": "box",
                "at": ["70 mm", "-40 mm"],
                "yaw": "30 deg",
                "shape": "box",
                "length": "80 mm",
                "width": "50 mm",
                "height": "90 mm",
                "liquid_height": "45 mm",
                "empty_mass": "40 g",
            },
            cup
            | {
                "name": "cup",
                "at": ["-90 mm", "-40 mm"],
                "shape": "cylinder",
                "radius": "25 mm",
                "height": "99 mm",
                "liquid_height": "40 mm",
                "empty_mass": "30 g",
            },
            {
                "name": "block",
                "at": ["80 mm", "70 mm"],
                "shape": "cylinder",
                "radius": "33 mm",
                "height": "60 mm",
                "mass": "0.4 kg",
            },
        ],
        "path": {"type": "preset", "name": "arc", "yaw": ["0 deg", "90 deg"]},
        "motion": {"end": "residual", "tilt": "free"},
    }
    return film_of(scene_from_table(table, name="mixed"))
