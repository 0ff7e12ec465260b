"""Pictures of the pages, drawn by the package's own functions when the build starts.

A picture is a function that returns a figure: without arguments, or with plans of bundled examples, or with the
evidence of one. It is a function in one of the files here and a line in the table below.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from matplotlib.figure import Figure

from nospill.certification.certificate import judge
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plots.evidence import Evidence
from nospill_docs.gallery import planned_example
from nospill_docs.pictures import films, forces, judged, liquids, maps, runs, stills, studies, vessels, ways
from nospill_docs.pictures.paper import look, write
from nospill_docs.places import Places, copy_if_changed
from nospill_docs.transcripts import planned_session

TWO_CUPS = "two-cups"
"""The plan of the session on the page "Get started", which is no bundled example."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture of the pages.

    Attributes:
        draw: what draws it.
        plans: names of the examples whose plans or evidence it takes, in the order of its arguments.
        pixels: whether it is written as pixels, for what is no line drawing.
    """

    draw: Callable[..., Figure]
    plans: tuple[str, ...] = ()
    pixels: bool = False

    @property
    def suffix(self) -> str:
        """Of its file."""
        return ".png" if self.pixels else ".svg"


PICTURES: dict[str, Picture] = {
    "frames": Picture(forces.frames),
    "apparent-gravity": Picture(forces.apparent_gravity),
    "forces-on-a-cup": Picture(forces.forces_on_a_cup),
    "friction-lever": Picture(forces.friction_lever),
    "modes": Picture(liquids.modes),
    "paraboloid": Picture(liquids.paraboloid),
    "after-the-end": Picture(liquids.after_the_end),
    "closed-form": Picture(liquids.closed_form),
    "shapes": Picture(vessels.shapes),
    "elements": Picture(vessels.elements),
    "annotated-certificate": Picture(judged.annotated_certificate, (TWO_CUPS,)),
    "between-samples": Picture(judged.between_samples, ("matrix-liquid-tilt",)),
    "coarse-samples": Picture(judged.coarse_samples),
    "warnings": Picture(judged.warnings),
    "chain-of-integrators": Picture(judged.chain_of_integrators, ("matrix-liquid-tilt",)),
    "certificate-in-steps": Picture(judged.certificate_in_steps),
    "smoothing": Picture(ways.smoothing),
    "approach": Picture(ways.approach, (TWO_CUPS,)),
    "reasons": Picture(ways.reasons, (TWO_CUPS,)),
    "tornado": Picture(studies.tornado, ("matrix-liquid-tilt",)),
    "corners": Picture(studies.corners, ("matrix-liquid-tilt", "matrix-liquid-tilt-robust")),
    "measured-peaks": Picture(studies.measured_peaks),
    "late-arm": Picture(runs.run_of_a_late_arm, ("matrix-liquid-tilt",)),
    "film-of-a-cup": Picture(films.film_of_a_cup, pixels=True),
    "campaign": Picture(studies.campaign),
    "planning-times": Picture(studies.planning_times),
    "commands": Picture(maps.commands),
    "plan-folder": Picture(maps.plan_folder),
    "scenario": Picture(maps.scenario, (TWO_CUPS,)),
    "moments": Picture(stills.strip, (TWO_CUPS,), pixels=True),
    "views": Picture(stills.views, ("matrix-liquid-tilt",), pixels=True),
    "around-a-column": Picture(stills.around_a_column, ("cups-around-a-column",), pixels=True),
    "robots": Picture(stills.robots, pixels=True),
}
"""Name of the file in `_generated/pictures` -> what it is."""

RESOLUTION = 220
"""Dots per inch of those that are pixels: sharp on a screen of high density."""


class Shelf:
    """Plans that pictures are drawn from, each read and judged once."""

    def __init__(self, places: Places) -> None:
        """Of one build."""
        self._places = places
        self._read: dict[str, Evidence] = {}

    def folder(self, name: str) -> Path:
        """The plan folder of an example."""
        return planned_session(self._places) if name == TWO_CUPS else planned_example(self._places, name)

    def evidence(self, name: str) -> Evidence:
        """A plan and its judgement."""
        if name not in self._read:
            plan = load_plan(self.folder(name))
            self._read[name] = Evidence(plan, judge(plan.trajectory, plan.scene))
        return self._read[name]

    def arguments(self, picture: Picture) -> list[Plan | Evidence]:
        """What a picture is drawn from."""
        wanted = inspect.signature(picture.draw).parameters
        found = [self.evidence(name) for name in picture.plans]
        return [one if name == "evidence" else one.plan for name, one in zip(wanted, found, strict=True)]


def write_pictures(places: Places) -> None:
    """Draw every picture; those of a file are kept until it, the package or what it reads has changed."""
    shelf = Shelf(places)
    modules: dict[ModuleType, list[str]] = {}
    for name, picture in PICTURES.items():
        modules.setdefault(_module(picture), []).append(name)
    for module, names in modules.items():
        key = _key(places, module)

        def draw(folder: Path, names: list[str] = names) -> None:
            with look():
                for name in names:
                    picture = PICTURES[name]
                    figure = picture.draw(*shelf.arguments(picture))
                    place = folder / f"{name}{picture.suffix}"
                    if picture.pixels:
                        figure.savefig(place, dpi=RESOLUTION)
                    else:
                        write(figure, place)

        made = places.cached(f"pictures-{module.__name__.rpartition('.')[2]}", key, draw)
        for name in names:
            file = f"{name}{PICTURES[name].suffix}"
            copy_if_changed(made / file, places.generated / "pictures" / file)


def _module(picture: Picture) -> ModuleType:
    found = inspect.getmodule(picture.draw)
    assert found is not None
    return found


def _key(places: Places, module: ModuleType) -> str:
    """The text of a file of pictures and of what it reads beside the package's own digest."""
    texts = [Path(str(module.__file__)).with_name(name) for name in ("__init__.py", "paper.py")]
    texts += [Path(str(module.__file__)), *(places.docs / page for page in getattr(module, "READS", ()))]
    return "".join(path.read_text(encoding="utf-8") for path in texts)
