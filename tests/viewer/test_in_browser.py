"""The file and the live viewer in headless Chromium: they play, need no network, and show arm, tray and four cups."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from nospill.drawing.timeline import Film, make_film
from nospill.drawing.views import View

pytest.importorskip("viser", reason="viser is not installed")
# Playwright's own loop leaves sockets to the garbage collector.
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::ResourceWarning")]

from nospill.viewer.charts import draw_charts  # noqa: E402
from nospill.viewer.html import CLOCK, save_html, with_charts  # noqa: E402
from nospill.viewer.live import live_viewer, short_titles  # noqa: E402
from nospill.viewer.playback import SPEEDS  # noqa: E402
from tests.films import UNLIKE  # noqa: E402
from tests.waiting import PATIENCE, wait_until  # noqa: E402

CURSOR = "document.documentElement.style.getPropertyValue('--nospill-x')"
WIDTH, HEIGHT = 470, 410
"""px; the scene's part of the window, without charts and player."""


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """A page that keeps the addresses it asked for in `page.asked` and its errors in `page.errors`."""
    found = browser.new_page(viewport={"width": 860, "height": 460})
    found.set_default_timeout(1e3 * PATIENCE)
    found.asked, found.errors = [], []
    found.on("request", lambda request: found.asked.append(request.url))
    found.on("websocket", lambda socket: found.asked.append(socket.url))
    found.on("pageerror", lambda error: found.errors.append(str(error)))
    yield found
    found.close()


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, tilting_film: Film) -> Path:
    path = tmp_path_factory.mktemp("page") / "tilt.html"
    assert save_html([tilting_film], path) == path.stat().st_size < 5_000_000
    return path


def picture(page: Any) -> np.ndarray:
    """The scene's part of the window, (height, width, 3), as numbers."""
    with Image.open(io.BytesIO(page.screenshot())) as image:
        return np.asarray(image.convert("RGB"), dtype=float)[:HEIGHT, :WIDTH]


def open_page(page: Any, address: str) -> None:
    """Go there, wait for the player and, live, put the notice about software rendering away; the file has none."""
    page.goto(address)
    page.wait_for_selector(".nospill-cursor", state="attached")
    page.wait_for_selector("#root [role=slider]", state="attached")
    if address.startswith("http:"):
        page.locator(".mantine-Notification-closeButton").click()


def page_pause(page: Any) -> Callable[[float], object]:
    """Let s pass and the page live meanwhile."""
    return lambda seconds: page.wait_for_timeout(1e3 * seconds)


def eventually(page: Any, right: Callable[[np.ndarray], bool], what: str) -> np.ndarray:
    """Wait until the picture is right: one is as much work as a second of the page, so few are taken."""
    found = picture(page)

    def seen() -> bool:
        nonlocal found
        found = picture(page)
        return right(found)

    wait_until(seen, f"{what} to be seen", pause=lambda _: page.wait_for_timeout(300))
    return found


def liquids(pixels: np.ndarray) -> int:
    """Separate blue bodies."""
    red, green, blue = np.moveaxis(pixels, 2, 0)
    labels, count = ndimage.label(ndimage.binary_closing((blue > red + 40) & (blue > green + 15), iterations=2))  # pyright: ignore[reportGeneralTypeIssues]
    sizes = ndimage.sum_labels(np.ones(labels.shape), labels, np.arange(1, count + 1))
    return int(np.count_nonzero(sizes > 1000))


def cups(pixels: np.ndarray) -> float:
    """Share of the picture in the blue of liquids at rest."""
    red, green, blue = np.moveaxis(pixels, 2, 0)
    return share((blue > red + 40) & (blue > green + 15))


def share(mask: np.ndarray) -> float:
    """Part of the picture a mask covers where it is more than a thin line."""
    return float(np.mean(ndimage.binary_erosion(mask, iterations=3)))


def tray(pixels: np.ndarray) -> float:
    """Share of the picture in the board's warm tint."""
    red, _, blue = np.moveaxis(pixels, 2, 0)
    return share((red > blue + 5) & (red > 150))


def arm(pixels: np.ndarray) -> float:
    """Share of the picture in the arm's grey; the ground is lighter, its lines are thin."""
    return share((np.ptp(pixels, axis=2) < 25) & (pixels.mean(axis=2) < 225) & (pixels.mean(axis=2) > 90))


def played(page: Any) -> float:
    """The player's clock, s."""
    return page.evaluate("+document.querySelector('[role=slider]').getAttribute('aria-valuenow')")


@pytest.mark.slow
def test_file_plays_from_the_disk_without_network(page: Any, file: Path, tilting_film: Film) -> None:
    open_page(page, f"file://{file}")
    shown = [played(page)]
    for _ in range(3):  # a pass that ends starts again at zero
        wait_until(lambda: played(page) != shown[-1], "the motion plays", pause=page_pause(page))
        shown.append(played(page))
    assert page.locator("#nospill-speed option").all_inner_texts() == list(SPEEDS)
    page.wait_for_function(f"was => {CURSOR} != was", arg=page.evaluate(CURSOR))
    page.keyboard.press("Space")

    def at_rest(found: np.ndarray) -> bool:
        if liquids(found) >= 3 and cups(found) > 0.05 and tray(found) > 0.03:  # liquid alone is half of a cup
            return True
        for place in ("0.3", "0"):  # a busy page drops poses that it is given while it still builds what they are of
            page.locator("#root input").first.fill(place)
            page.wait_for_timeout(500)
        return False

    page.locator("#root input").first.fill("0")
    pixels = eventually(page, at_rest, "a tray with four cups")
    assert pixels.std() > 15  # not blank
    assert page.locator("#nospill-side polyline").count() == 4 + 4 + 6
    assert page.inner_text("#nospill-side h1").startswith("matrix-liquid-tilt (tilting): ")
    assert [address for address in page.asked if not address.startswith(("file:", "data:", "blob:"))] == []
    assert page.errors == []


OVERLAPS = """() => {
  const nodes = [...document.querySelectorAll('#nospill-side :is(text, h1, p, .nospill-key div)')];
  // a sentence takes four lines, anything else less
  const box_of = node => [node.textContent, node.getBoundingClientRect(), node.tagName === 'P' ? 80 : 60];
  const found = nodes.filter(node => node.textContent.trim()).map(box_of);
  const side = document.getElementById('nospill-side').getBoundingClientRect(), wrong = [];
  found.forEach(([text, box, most], number) => {
    if (box.left < side.left || box.right > side.right + 1) wrong.push([text, 'cut']);
    if (box.height > most || box.height < 8) wrong.push([text, 'size']);
    found.slice(number + 1).forEach(([other, its]) => {
      const wide = Math.min(box.right, its.right) - Math.max(box.left, its.left);
      const tall = Math.min(box.bottom, its.bottom) - Math.max(box.top, its.top);
      if (wide > 1 && tall > 3) wrong.push([text, other]);
    });
  });
  return wrong;
}"""
"""Texts that cover another one, stick out or are of another size; the rims of a line of text hold no letters."""


def test_no_text_of_two_plans_covers_another_in_any_window(
    page: Any, tmp_path: Path, level_film: Film, tilting_film: Film
) -> None:
    film = level_film if level_film.length > tilting_film.length else tilting_film
    films = [make_film(each.plan, each.judgement, rate=4.0, length=film.length) for each in (level_film, tilting_film)]
    save_html(films, tmp_path / "two.html")
    open_page(page, f"file://{tmp_path / 'two.html'}")
    page.keyboard.press("Space")
    for width, columns in ((1280, 1), (760, 2), (400, 1)):
        page.set_viewport_size({"width": width, "height": 700})
        assert page.evaluate(OVERLAPS) == []
        tops = page.eval_on_selector_all(".nospill-chart", "nodes => nodes.map(n => n.getBoundingClientRect().top)")
        assert len(tops) // len(set(tops)) == columns
        sizes = page.eval_on_selector_all(".nospill-chart", "nodes => nodes.map(n => n.getBoundingClientRect().width)")
        assert max(sizes) <= 420.0
    assert page.errors == []


@pytest.mark.parametrize("name", UNLIKE)
def test_no_text_of_an_example_covers_another_in_any_window(
    page: Any, name: str, example_film: Callable[[str], Film]
) -> None:
    film = example_film(name)
    blank = "<html><head><title>Viser</title></head><body><div id='root'></div></body></html>"
    page.set_content(with_charts(blank, [film], draw_charts([film], short_titles([film]))))
    for width in (1280, 760, 400):
        page.set_viewport_size({"width": width, "height": 700})
        assert page.evaluate(OVERLAPS) == []
    assert page.errors == []


def test_the_clock_of_the_file_runs_at_the_speed_chosen(page: Any) -> None:
    """A time that the test sets, seen through the file's clock: a quarter of it first, then the speed chosen."""
    options = "<option value='0.25'>a</option><option value='2.0'>b</option>"
    page.set_content(f"<select id='nospill-speed'>{options}</select>")
    page.evaluate("() => { window.real = 1000; Date.now = () => window.real }")
    page.evaluate(CLOCK)
    page.evaluate("() => { window.real += 400 }")
    assert page.evaluate("Date.now()") == 1100
    page.select_option("#nospill-speed", label="b")
    page.evaluate("() => { window.real += 400 }")
    assert page.evaluate("Date.now()") == 1900


@pytest.mark.slow
def test_file_shows_the_arm(page: Any, tmp_path: Path, tilting_film: Film) -> None:
    save_html([tilting_film], tmp_path / "arm.html", view=View.ARM)
    open_page(page, f"file://{tmp_path / 'arm.html'}")
    page.keyboard.press("Space")
    pixels = eventually(page, lambda found: arm(found) > 0.02, "the arm")
    whole = ndimage.binary_erosion(np.ptp(pixels, axis=2) < 25, iterations=2) & (pixels.mean(axis=2) < 225)
    rows, columns = np.nonzero(ndimage.binary_erosion(whole, iterations=2))
    assert rows.min() > 5  # nothing clipped
    assert rows.max() < HEIGHT - 5
    assert 5 < columns.min() < columns.max() < WIDTH - 5


@pytest.mark.slow
def test_live_viewer_plays(page: Any, tilting_film: Film) -> None:
    with live_viewer([tilting_film], port=0) as (address, player):
        open_page(page, address)
        page.get_by_role("button", name="Pause").click()
        page.get_by_role("button", name="Play", exact=True).wait_for()
        assert not player.clock.playing
        player.clock.seek(0.0)
        eventually(page, lambda found: liquids(found) >= 3 and tray(found) > 0.03, "a tray with four cups")
        start = played(page)
        page.get_by_role("button", name="Play", exact=True).click()
        page.wait_for_function(
            "start => document.querySelector('[role=slider]').getAttribute('aria-valuenow') != start", arg=str(start)
        )
        assert page.locator("polyline").count() == 4 + 4 + 6
        for label in ("Time [s]", "Speed", "Loop", "Names", "Path"):
            assert page.get_by_text(label, exact=True).count() == 1
        page.get_by_role("button", name="whole arm").click()
        pixels = eventually(page, lambda found: arm(found) > 0.02, "the arm")
        assert np.ptp(pixels) > 100
        page.goto("about:blank")
    host = address.partition("//")[2]
    allowed = (f"http://{host}", f"ws://{host}", "data:", "blob:", "about:")
    assert [found for found in page.asked if not found.startswith(allowed)] == []
    assert page.errors == []
