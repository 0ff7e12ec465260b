"""Pictures of the studio and the viewer, taken by the build in a browser without a window.

Where there is no browser, or no library to drive it, the pages say so in the pictures' place.
"""

from __future__ import annotations

import contextlib
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from nospill_docs.environment import once_for_a_page
from nospill_docs.gallery import viewer_is_there
from nospill_docs.places import Places, copy_if_changed, write_if_changed

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
EXAMPLE, SCENE = "mixed-tray", "matrix-liquid-tilt"
"""What the studio is opened with; the example of the gallery whose motion the viewer shows."""

_PATIENCE = 240e3
"""ms; for the slowest of the steps on a busy machine."""
_SETTLED = 3000
"""ms in which a browser without a graphics card has drawn what it was sent."""
_FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")

_SCREENS: dict[str, tuple[tuple[str, str], ...]] = {
    "studio": (
        ("studio", f"The studio with the example {EXAMPLE}, planned; the tray is laid out beside the arm."),
        ("studio-phone", "The same 400 px wide, after an edit: the last answer is grey."),
    ),
    "viewer": (("viewer", f"The example {SCENE} in the one-file viewer, followed by the camera."),),
}
"""Page -> names of its pictures and what stands below them."""


def write_screens(places: Places) -> None:
    """Take the pictures and write what the site puts into the two pages."""
    takers: dict[str, Callable[[Any, Path], None]] = {
        "studio": _studio,
        "viewer": lambda browser, target: _viewer(browser, places, target),
    }
    for page, screens in _SCREENS.items():
        if not browser_is_there():
            text = "*The picture is missing here: this site was built on a machine without a browser.*\n"
        else:
            folder = _taken(places, page, takers[page])
            text = "".join(
                f"```{{figure}} _generated/screens/{name}.png\n:alt: {caption}\n"
                f"{':width: 45%' if name.endswith('phone') else ':width: 100%'}\n\n{caption}\n```\n\n"
                for name, caption in screens
            )
            for name, _ in screens:
                copy_if_changed(folder / f"{name}.png", places.generated / "screens" / f"{name}.png")
        write_if_changed(places.generated / f"screens-{page}.md", text)


def browser_is_there() -> bool:
    """Whether there is a browser, what drives it, and what it is to show."""
    driven = importlib.util.find_spec("playwright") is not None
    return driven and viewer_is_there() and any(map(shutil.which, BROWSERS))


def _taken(places: Places, page: str, take: Callable[[Any, Path], None]) -> Path:
    root = Path(str(importlib.util.find_spec("nospill").origin)).parent  # type: ignore[union-attr]
    sources = [path for part in ("studio", "viewer") for path in sorted((root / part).rglob("*.py"))]
    key = "".join(path.read_text(encoding="utf-8") for path in [*sources, Path(__file__)])

    def make(target: Path) -> None:
        with _browser() as browser:
            take(browser, target)

    return places.cached(f"screen-{page}", key, make)


@contextlib.contextmanager
def _browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    program = next(filter(None, map(shutil.which, BROWSERS)))
    with sync_playwright() as started:
        found = started.chromium.launch(executable_path=program, args=list(_FLAGS))
        try:
            yield found
        finally:
            found.close()


def _tab(browser: Any, address: str, size: tuple[int, int]) -> Any:
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.set_default_timeout(_PATIENCE)
    page.goto(address)
    return page


def _studio(browser: Any, target: Path) -> None:
    """Open an example, plan it, and take it wide; edit it on a phone, and take that."""
    with _running_studio() as address:
        for name, size in (("studio", (1280, 800)), ("studio-phone", (400, 800))):
            page = _tab(browser, address, size)
            page.wait_for_selector("#nospill-object-0")
            page.add_style_tag(content="[class*=Notifications-root]{display:none}")
            page.get_by_role("button", name="Plan", exact=True).click()
            page.wait_for_selector("#nospill-verdict")
            if name == "studio-phone":
                page.locator("#nospill-object-0").focus()
                page.keyboard.press("ArrowRight")
                page.wait_for_selector("#nospill-previous")
            page.wait_for_timeout(_SETTLED)
            page.screenshot(path=target / f"{name}.png")
            page.close()


@contextlib.contextmanager
def _running_studio() -> Iterator[str]:
    program = [sys.executable, "-c", "from nospill.cli import main; main()"]
    process = subprocess.Popen(
        [*program, "studio", EXAMPLE, "--port", "0", "--no-browser"],
        env=once_for_a_page(),
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split()[0]
    finally:
        process.terminate()  # a build in the background of a shell has interrupts ignored
        process.communicate()


def _viewer(browser: Any, places: Places, target: Path) -> None:
    """Stop the motion of the gallery's page where the tray leans, and take it."""
    scene = places.generated / "extra" / "scenes" / f"{SCENE}.html"
    page = _tab(browser, scene.resolve().as_uri(), (1280, 800))
    page.wait_for_selector("#root [role=slider]", state="attached")
    page.wait_for_timeout(_SETTLED)
    page.keyboard.press("Space")
    for place in ("0.3", "0.42"):  # a busy page drops what it is given while it still builds
        page.locator("#root input").first.fill(place)
        page.wait_for_timeout(_SETTLED)
    page.screenshot(path=target / "viewer.png")
    page.close()
