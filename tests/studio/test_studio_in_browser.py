"""The studio in headless Chromium: by keyboard on a phone, wrong values and no motion, two tabs."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")
pytestmark = [
    pytest.mark.slow,
    # Playwright's own loop leaves sockets to the garbage collector.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    # The server ignores it, too; pytest sets the filters anew between a fixture and its test.
    pytest.mark.filterwarnings(r"ignore:Queued a \w+ on a closed connection"),
]

from nospill.core.units import quantity  # noqa: E402
from nospill.scenario import read_scenario, scene_from_table  # noqa: E402
from nospill.studio.server import studio  # noqa: E402
from nospill.studio.session import Session  # noqa: E402
from tests.waiting import PATIENCE, finished, first_line, wait_until  # noqa: E402

COMMAND = [sys.executable, "-c", "from nospill.cli import main; main()"]


@pytest.fixture
def open_tab(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open a tab at an address; at the end none of them may have met an error."""
    tabs, errors = [], []

    def new(address: str, width: int = 600) -> Any:
        page = browser.new_page(viewport={"width": width, "height": 800})
        page.set_default_timeout(1e3 * PATIENCE)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        page.wait_for_selector("#nospill-object-0")
        page.add_style_tag(content="[class*=Notifications-root]{display:none}")  # the one about software rendering
        tabs.append(page)
        return page

    yield new
    for page in tabs:
        page.close()
    assert errors == []


def field(page: Any, label: str) -> Any:
    """The input behind a label."""
    return page.get_by_label(label, exact=True).first


def tab_to(page: Any, name: str) -> None:
    """Press the tabulator until what has the focus is called so."""
    called = "(() => { const e = document.activeElement; return e.getAttribute('aria-label') || e.textContent; })()"

    passed: set[str] = set()

    def reached() -> bool:
        page.keyboard.press("Tab")
        at = page.evaluate(called)
        if at not in passed:
            print("the tabulator leads to", repr(at))  # seen where the test fails
        passed.add(at)
        return at.startswith(name)

    until(page, reached, f"a tabulator that leads to {name}")


def press(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def drag(page: Any, number: int, right: float, up: float) -> None:
    """Drag an object by so many mm."""
    shape = page.locator(f"#nospill-object-{number} circle").first.bounding_box()
    scale = page.evaluate("document.getElementById('nospill-tray').getScreenCTM().a")  # px per mm
    x, y = shape["x"] + shape["width"] / 2, shape["y"] + shape["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 0.5 * scale * right, y - 0.5 * scale * up, steps=4)
    page.mouse.move(x + scale * right, y - scale * up, steps=4)
    page.mouse.up()


def until(page: Any, true: Callable[[], bool], what: str) -> None:
    wait_until(true, what, pause=lambda seconds: page.wait_for_timeout(1e3 * seconds))


def answered(page: Any) -> float:
    """Wait for a verdict where there was none before; the duration, s. Progress may be too short to be seen."""
    page.wait_for_selector("#nospill-verdict")
    assert page.inner_text("#nospill-status").startswith("certified")
    return float(page.get_attribute("#nospill-verdict", "data-duration"))


@contextlib.contextmanager
def command(*arguments: str) -> Iterator[str]:
    """A running `nospill studio`, ended as by Ctrl-C; its address."""
    process = subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield first_line(process, "nospill studio").split()[0]
        process.send_signal(signal.SIGINT)
        _, errors = finished(process, "nospill studio after Ctrl-C")
        assert (process.returncode, errors) == (0, "")
    finally:
        process.kill()
        process.communicate()


def test_a_phone_and_a_keyboard_suffice_to_move_fill_plan_and_save(
    tmp_path: Path, table: dict[str, Any], open_tab: Callable[..., Any]
) -> None:
    file = tmp_path / "table.toml"
    scene_from_table(table | {"name": "table"}, name="table").save(file)
    with command("studio", str(file), "--port", "0", "--no-browser") as address:
        assert address.startswith("http://127.0.0.1:")
        page = open_tab(address, width=400)
        keys = page.keyboard
        scene, sheet = page.locator("canvas[data-engine]").bounding_box(), page.locator("#nospill-tray").bounding_box()
        assert scene["width"] == 400.0 and scene["y"] + scene["height"] <= sheet["y"]  # side by side, not behind
        assert sheet["x"] >= 0.0 and sheet["x"] + sheet["width"] <= 400.0
        tab_to(page, "left, x ")
        for key, name, place in (("Right", "At x", "5 mm"), ("Right", "At x", "10 mm"), ("Down", "At y", "65 mm")):
            keys.press(f"Arrow{key}")
            until(page, lambda name=name, place=place: field(page, name).input_value() == place, "the cup has moved")
            page.wait_for_function(
                "document.activeElement.id == 'nospill-object-0'"
            )  # drawn anew, it has the focus again
        tab_to(page, "Liquid height")
        assert page.get_attribute(":focus", "placeholder") == "from the volume"
        keys.press("Control+a")
        keys.insert_text("45 mm")  # at once: no half a value may switch Plan off
        tab_to(page, "Plan")
        keys.press("Enter")
        duration = answered(page)
        tab_to(page, "Max slosh height")
        keys.press("Control+a")
        keys.insert_text("14 mm")
        page.get_by_text(f"previous: {duration:.3f} s").wait_for()
        assert page.locator("#nospill-verdict").count() == 0
        keys.press("Control+z")
        until(page, lambda: field(page, "Max slosh height").input_value() == "15 mm", "undone")
        page.wait_for_selector("#nospill-verdict")  # it is the answer to this scenario
        keys.press("Control+Shift+z")
        page.wait_for_selector("#nospill-previous")
        tab_to(page, "Plan")
        keys.press("Enter")
        assert answered(page) > duration  # less may slosh
        keys.press("Control+z")
        page.wait_for_selector("#nospill-previous")
        tab_to(page, "Tray")
        for name in ("Around", "Scenario", "Certificate", "Motion", "Files"):
            keys.press("ArrowRight")
            page.get_by_role("tab", name=name, selected=True).wait_for()
        assert page.locator("#nospill-certificate tbody tr").count() > 10
        assert page.locator("#nospill-warnings li").count() > 0
        tab_to(page, "Save as")
        keys.press("Control+a")
        keys.type("saved")
        page.get_by_text("saved · nospill studio").wait_for()
        tab_to(page, "Save")
        keys.press("Enter")
        page.get_by_text(f"Written to {tmp_path / 'saved.toml'}").wait_for()
        page.goto("about:blank")
    again = ["plan", str(tmp_path / "saved.toml"), "--no-figures", "-o", str(tmp_path / "plan")]
    subprocess.run([*COMMAND, *again], check=True)
    summary = json.loads((tmp_path / "plan" / "summary.json").read_text())
    assert summary["status"] == "certified as published"
    assert summary["duration_s"] == pytest.approx(duration, abs=1e-6)


@pytest.fixture
def running(
    tmp_path: Path, table: dict[str, Any], capfd: pytest.CaptureFixture[str]
) -> Iterator[tuple[str, dict[int, Session]]]:
    """A studio, its address and its sessions; at the end no thread of it may have complained."""
    sessions: dict[int, Session] = {}
    with studio(table, folder=tmp_path, port=0, sessions=sessions) as address:
        yield address, sessions
    assert capfd.readouterr().err == ""


def test_what_is_wrong_is_marked_and_plans_nothing(
    running: tuple[str, dict[int, Session]], open_tab: Callable[..., Any]
) -> None:
    address, sessions = running
    page = open_tab(address, width=720)
    (session,) = sessions.values()
    button = page.get_by_role("button", name="Plan", exact=True)
    drag(page, 0, 0.0, -100.0)
    page.get_by_text("left and right overlap").wait_for()
    assert page.locator("#nospill-tray [data-fits=false]").count() == 2
    assert button.is_disabled()
    page.wait_for_timeout(1000)  # the last report of the drag would undo what follows
    press(page, "Undo")
    page.wait_for_function("!document.getElementById('nospill-faults')")
    for label, wrong, says, right in (
        ("Liquid height", "120 mm", "liquid height 120 mm is above the rim", "49 mm"),
        ("Radius", "35 bananas", "unknown unit", "35 mm"),
        ("At x", "160 mm", "over the edge", "0 mm"),
        ("At y", "-50 mm", "", "70 mm"),
        ("Speed scale", "120 %", "out of range", ""),
    ):
        if label == "Speed scale":
            page.get_by_role("tab", name="Scenario").click()
        entry = field(page, label)
        entry.fill(wrong)
        page.get_by_text("to correct before planning").wait_for()
        note = page.locator(".nospill-fault").first
        if says:
            assert says in note.inner_text()
            box, below = entry.bounding_box(), note.bounding_box()
            assert 0.0 <= below["y"] - (box["y"] + box["height"]) < 15.0  # right below what was typed
            assert entry.get_attribute("aria-invalid") == "true"
            red = "([e, red]) => getComputedStyle(e).borderTopColor === red"
            page.wait_for_function(red, arg=[entry.element_handle(), "rgb(154, 67, 0)"])
        assert button.is_disabled()
        button.click(force=True)
        page.wait_for_timeout(150)
        assert session.desk.state.stage == "idle"
        assert page.locator("#nospill-verdict").count() == 0
        entry.fill(right)
        page.wait_for_function("!document.getElementById('nospill-faults')")
        assert page.locator(".nospill-fault").count() == 0
        assert button.is_enabled()
    assert entry.get_attribute("aria-invalid") == "false" and entry.get_attribute("placeholder") == "1"
    field(page, "Max duration").fill("0.5 s")
    press(page, "Plan")
    page.get_by_text("no motion", exact=True).wait_for()
    assert page.inner_text("#nospill-status") == "failed"
    field(page, "Max duration").fill("")
    page.wait_for_function("!document.getElementById('nospill-status')")
    field(page, "Offset x, y, z").fill("3, 0, 0")
    page.wait_for_selector("#nospill-obstacle")
    assert button.is_disabled() and "does not reach" in page.inner_text("#nospill-headline")
    press(page, "Undo")
    page.wait_for_function("!document.getElementById('nospill-obstacle')")
    assert button.is_enabled()
    page.get_by_role("tab", name="Tray", exact=True).click()
    field(page, "Liquid height").fill("")
    field(page, "Liquid height").press_sequentially("47.125 mm")  # as fast as the browser can
    until(page, lambda: session.draft.value(("cargo", 0, "liquid_height")) == "47.125 mm", "every key has arrived")
    camera = session.camera
    far = camera.position
    page.set_viewport_size({"width": 600, "height": 800})
    until(page, lambda: bool(np.any(np.abs(camera.position - far) > 0.1)), "the camera stands back in a narrow window")


def test_arrows_move_an_obstacle_in_the_layout(
    tmp_path: Path, open_tab: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    """The column of the example is drawn along y by the green arrow, which is one step back."""
    sessions: dict[int, Session] = {}
    with studio(read_scenario("cups-around-a-column").source, folder=tmp_path, port=0, sessions=sessions) as address:
        page = open_tab(address, width=1280)
        (session,) = sessions.values()
        before = session.draft.obstacles[0]["at"]
        until(page, lambda: float(np.linalg.norm(session.camera.look_at)) > 0.1, "the camera to see the scene whole")
        until(
            page, lambda: drawn_along_y(page, session, 0.12, 0.42), "the column to be drawn as far as the mouse moved"
        )
        page.wait_for_timeout(1000)  # for what is still on its way
        x, y, z = place_of(session)
        assert (x, z) == (0.86, 0.45) and y == pytest.approx(round(y / 0.005) * 0.005)
        press(page, "Undo")
        until(page, lambda: session.draft.obstacles[0]["at"] == before, "the column to be back")
        page.get_by_role("tab", name="Around").click()
        press(page, "Remove this obstacle")
        until(page, lambda: len(session.draft.obstacles) == 1, "the column to be gone")
    assert capfd.readouterr().err == ""


def drawn_along_y(page: Any, session: Session, first: float, last: float) -> bool:
    """Draw the column's green arrow from one y to another, m; whether it went with the mouse, else it is back.

    A busy page has not drawn the arrows yet, or takes hold of one late and moves it by less.
    """
    before = session.draft.obstacles[0]["at"]
    camera = session.camera
    position, middle = np.array(camera.position), np.array(camera.look_at)
    begin, end = (on_screen(page, session, np.array([0.86, y, 0.45])) for y in (first, last))
    page.mouse.move(*begin)
    page.wait_for_timeout(300)
    page.mouse.down()
    for share in np.linspace(0.0, 1.0, 6):
        page.mouse.move(*(begin + share * (end - begin)))
        page.wait_for_timeout(100)
    page.mouse.up()
    for _ in range(10):  # what is reported late counts too
        page.wait_for_timeout(500)
        if place_of(session)[1] == pytest.approx(last - first, abs=0.1):
            return True
    if session.draft.obstacles[0]["at"] != before:
        press(page, "Undo")
        until(page, lambda: session.draft.obstacles[0]["at"] == before, "the column to be back")
    # A mouse that takes hold of no arrow turns the camera, and from elsewhere the arrow may be hidden.
    camera.position, camera.look_at = position, middle
    return False


def place_of(session: Session) -> list[float]:
    """Of the first obstacle, m."""
    return [quantity(value, "length") for value in session.draft.obstacles[0]["at"]]


def on_screen(page: Any, session: Session, point: np.ndarray) -> np.ndarray:
    """Where a point, m, is in the page, px."""
    camera, canvas = session.camera, page.locator("canvas[data-engine]").bounding_box()
    ahead = np.asarray(camera.look_at) - camera.position
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    gap = point - camera.position
    scale = canvas["height"] / 2 / np.tan(camera.fov / 2) / (gap @ ahead)
    middle = np.array([canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2])
    return middle + scale * np.array([gap @ right, -gap @ np.cross(right, ahead)])
