"""The gallery: every bundled example planned, drawn and, where the viewer is installed, put into a page that plays."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from nospill.certification.wording import percent
from nospill.plans.loading import load_plan
from nospill.scenario.examples import EXAMPLES, example_path
from nospill_docs.environment import once_for_a_page
from nospill_docs.places import Places, copy_if_changed, write_if_changed
from nospill_docs.tables import markdown_table
from tests.example_plans import REPOSITORY, kept

CAPTIONS: dict[str, str] = {
    "summary": "Summary sheet: path, certificate, what holds the motion back, heights, joint speeds.",
    "limits": "Every limit above 90 % of use: when it holds the motion back, and for how much of its time.",
    "other-speeds": "Largest use of a limit on liquids and contacts when the motion is played more slowly.",
    "slosh-heights": "Height of each liquid at the wall, over its limit.",
    "margins": "How much of each limit every object uses.",
    "joints": "Joint positions, and joint speeds over their limits.",
    "tilt": "Tilt of the tray.",
}
"""Figure -> its caption; figures that a plan has and this table has not are shown with their name."""


def write_gallery(places: Places) -> None:
    """One page an example; plans are kept until the package or the scenario changes."""

    def made(name: str) -> tuple[Path, Path | None]:
        folder = planned_example(places, name)
        return folder, _scene(places, name, folder)

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        both = dict(zip(EXAMPLES, pool.map(made, EXAMPLES), strict=True))
    folders = {name: folder for name, (folder, _) in both.items()}
    for number, (name, about) in enumerate(EXAMPLES.items(), 1):
        scenario, folder = example_path(name).read_text(encoding="utf-8"), folders[name]
        pictures = sorted((folder / "figures").glob("*.png"), key=_order)
        for picture in pictures:
            copy_if_changed(picture, places.docs / "gallery" / f"{number:02d}-{name}" / picture.name)
        copy_if_changed(_moment(places, name, folder), places.docs / "gallery" / f"{number:02d}-{name}" / "moment.png")
        played = both[name][1] is not None
        page = _page(number, name, about, scenario, folder, [picture.stem for picture in pictures], played)
        write_if_changed(places.docs / "gallery" / f"{number:02d}-{name}.md", page)
    cards = "".join(
        _card(number, name, about, _summary(folders[name])) for number, (name, about) in enumerate(EXAMPLES.items(), 1)
    )
    write_if_changed(places.generated / "gallery.md", cards)


def planned_example(places: Places, name: str) -> Path:
    """The plan folder of a bundled example, planned where it or the package has changed."""
    scenario = example_path(name).read_text(encoding="utf-8")
    return places.cached(f"plan-{name}", scenario, lambda target: _plan(name, target / "plan")) / "plan"


def _plan(name: str, folder: Path) -> None:
    """A plan folder with all figures, of the plan that the tests have made of it or of a new one."""
    if kept(name) is None:
        _nospill("plan", name, "--all-figures", "-o", str(folder))
    else:
        _python("-m", "tests.example_plans", name, str(folder))
        _nospill("plot", str(folder))


def _nospill(*arguments: str) -> None:
    """Run the command line in a process of its own."""
    _python("-c", "from nospill.cli import main; main()", *arguments)


def _python(*arguments: str) -> None:
    """Run Python in a process of its own, in the repository; what it prints is shown only if it fails.

    Raises:
        RuntimeError: it failed.
    """
    program = [sys.executable, *arguments]
    done = subprocess.run(program, cwd=REPOSITORY, env=once_for_a_page(), text=True, capture_output=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(arguments)} failed ({done.returncode}): {done.stderr.strip()[-400:]}")


def viewer_is_there() -> bool:
    """Whether `nospill view` exists and its library is installed."""
    with contextlib.suppress(ModuleNotFoundError):
        from nospill.cli import GROUPS

        named = any(command.__name__ == "view" for commands in GROUPS.values() for command in commands)
        return named and importlib.util.find_spec("viser") is not None
    return False


def _scene(places: Places, name: str, folder: Path) -> Path | None:
    """The page that plays the motion, beside the site's pages; None without the viewer."""
    if not viewer_is_there():
        return None
    viewer = Path(str(importlib.util.find_spec("nospill").origin)).parent / "viewer"  # type: ignore[union-attr]
    key = "".join(path.read_text(encoding="utf-8") for path in sorted(viewer.rglob("*.py")))

    def make(target: Path) -> None:
        _nospill("view", str(folder), "--html", str(target / "scene.html"))

    made = places.cached(f"scene-{name}", f"{folder.parent.name} {key}", make) / "scene.html"
    copy_if_changed(made, places.generated / "extra" / "scenes" / f"{name}.html")
    return made


def _order(picture: Path) -> int:
    return list(CAPTIONS).index(picture.stem) if picture.stem in CAPTIONS else len(CAPTIONS)


def _summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def _moment(places: Places, name: str, folder: Path) -> Path:
    """The middle of the motion, seen from near."""
    from nospill_docs.pictures.stills import save_moment

    def make(target: Path) -> None:
        save_moment(load_plan(folder), target / "moment.png")

    return places.cached(f"moment-{name}", folder.parent.name, make) / "moment.png"


def _card(number: int, name: str, about: str, summary: dict[str, Any]) -> str:
    page = f"{number:02d}-{name}"
    said = (summary["held_back"], summary["certificate"]["full_model"])
    held = "".join(f"; {text}" for text in said if text)
    return (
        f"## {number}. [{name}]({page}.md)\n\n{about[:1].upper()}{about[1:]}.\n\n"
        f"```{{figure}} {page}/moment.png\n:alt: the tray of {name} in the middle of its motion\n:width: 70%\n"
        f":target: {page}.html\n\n{summary['duration_s']:.2f} s, {summary['status']}{held}.\n```\n\n"
    )


def _player(name: str) -> str:
    """A line below the picture: a click puts the scene in the picture's place; without a script it opens the scene."""
    script = (
        "var f=document.createElement('iframe'),p=this.closest('section').querySelector('img');"
        "f.className='player';f.src=this.href;f.title='the motion';p.replaceWith(f);this.parentNode.remove();"
        "return false"
    )
    return (
        f'<p class="play"><a href="../scenes/{name}.html" onclick="{script}">Play the motion</a> '
        "(one file, works without a network).</p>\n\n"
    )


def _page(number: int, name: str, about: str, scenario: str, folder: Path, pictures: list[str], scene: bool) -> str:
    summary = _summary(folder)
    heights, beside = summary["max_slosh_height_m"], summary["certificate"]["full_model"]
    facts = [
        ("status", summary["status"]),
        ("duration", f"{summary['duration_s']:.3f} s"),
        ("greatest acceleration of the tray", f"{summary['max_tray_acceleration_m_s2']:.2f} m/s²"),
        ("greatest tilt", f"{summary['max_tilt_deg']:.1f} deg"),
        (
            "greatest use of a joint speed",
            percent(summary["max_joint_speed_use"], summary["max_joint_speed_use"] <= 1.0),
        ),
        *([("beside the certificate", beside)] if beside else []),
        *((f"liquid in {cup}, greatest height", f"{1e3 * height:.2f} mm") for cup, height in heights.items()),
    ]
    still = f"```{{image}} {number:02d}-{name}/moment.png\n:alt: the tray of {name} in its motion\n```\n\n"
    play = _player(name) if scene else ""
    figures = "".join(
        f"```{{figure}} {number:02d}-{name}/{stem}.png\n:alt: {stem} of {name}\n"
        f":width: {100 if stem == 'summary' else 78}%\n\n{CAPTIONS.get(stem, stem)}\n```\n\n"
        for stem in pictures
    )
    return (
        f"# {number}. {name}\n\n{about[:1].upper()}{about[1:]}.\n\n{summary['message']}\n\n"
        f"{still}{play}{markdown_table(('result', 'value'), facts)}\n"
        f"```console\n$ nospill plan {name} -o out/{name}\n```\n\n## Figures\n\n{figures}"
        f"## Scenario\n\n```toml\n{scenario.rstrip()}\n```\n"
    )
