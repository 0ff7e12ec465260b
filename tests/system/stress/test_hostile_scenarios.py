"""Scenarios by somebody who means harm: a clear error, and nothing outside the output folder is read or written."""

from __future__ import annotations

import textwrap
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from nospill.cli import app
from nospill.errors import NospillError, ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.examples import example_path
from nospill.scenario.settings import changed_table
from tests.waiting import run_python

RIGID: dict[str, Any] = tomllib.loads(example_path("matrix-rigid").read_text(encoding="utf-8"))

URDF = load_robot("ur5e").urdf


def changed(place: str, value: object) -> dict[str, Any]:
    return changed_table(RIGID, {place: value})


def refusal(table: dict[str, Any], folder: Path | str = ".") -> str:
    with pytest.raises(ScenarioError) as caught:
        scene_from_table(table, name="hostile", folder=folder)
    message = str(caught.value)
    assert len(message.splitlines()) == 1 and len(message) < 600
    return message


@pytest.mark.parametrize("number", [1e308, -1e308, 10**400, 1e-320, "1e400 m", "9" * 400, float("inf"), float("nan")])
@pytest.mark.parametrize(
    "place",
    [
        "tray.size.0",
        "tray.friction",
        "tray.offset",
        "cargo.0.mass",
        "cargo.0.radius",
        "cargo.0.at.0",
        "motion.max_tilt",
        "motion.max_duration",
        "planning.intervals",
        "planning.starts",
        "output.rate",
    ],
)
def test_huge_numbers(place: str, number: object) -> None:
    if number == 1e-320 and place in ("tray.offset", "cargo.0.at.0", "cargo.0.mass"):
        pytest.skip("nearly zero is allowed here")
    try:
        scene_from_table(changed(place, number), name="hostile")
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1 and len(str(error)) < 600
    else:
        assert number == 1e-320  # bounds that only say "above zero"


@pytest.mark.parametrize(
    "name",
    ["../../etc/passwd", "/etc/passwd", "..", "a/b", "a\\b", "CON ", "a\nb", "\x1b[2J", "a" * 500, "ﬀ", "%2e%2e"],
)
@pytest.mark.parametrize("place", ["name", "cargo.0.name"])
def test_names_that_are_paths(name: str, place: str) -> None:
    message = refusal(changed(place, name))
    assert "is not a name" in message
    assert "\x1b" not in message


def test_a_file_name_full_of_control_characters_is_no_name_of_a_scene(tmp_path: Path) -> None:
    place = tmp_path / "a\x1b[2J..b.toml"
    place.write_text(tomli_w.dumps({key: value for key, value in RIGID.items() if key != "name"}))
    assert set(read_scenario(place).name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")


ENTITIES = {
    "external": '<!DOCTYPE robot [<!ENTITY secret SYSTEM "file://{}">]><robot name="&secret;">',
    "parameter": '<!DOCTYPE robot [<!ENTITY % remote SYSTEM "file://{}"> %remote;]><robot name="x">',
    "laughs": '<!DOCTYPE robot [<!ENTITY a "haha"><!ENTITY b "&a;&a;&a;&a;">]><robot name="&b;">',
    "spaced": '<?xml version="1.0"?>\n<!-- x -->\n<!doctype robot SYSTEM "file://{}"><robot name="x">',
}


@pytest.mark.parametrize("kind", ENTITIES)
@pytest.mark.parametrize("as_file", [True, False])
def test_urdf_with_entities(kind: str, as_file: bool, tmp_path: Path) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_text("the secret")
    body = URDF[URDF.index("<link") :]
    text = ENTITIES[kind].replace("{}", str(secret)) + body
    (tmp_path / "arm.urdf").write_text(text)
    table = changed("robot", {"urdf": "arm.urdf"} if as_file else {"urdf_text": text})
    message = refusal(table, tmp_path)
    assert "document type or entities" in message and "the secret" not in message


def test_urdf_whose_entities_are_in_another_encoding(tmp_path: Path) -> None:
    """UTF-16 would hide the declaration from a search in bytes; it is not read as a URDF at all."""
    text = ENTITIES["external"].replace("{}", "/etc/hostname") + URDF[URDF.index("<link") :]
    (tmp_path / "arm.urdf").write_bytes(('<?xml version="1.0" encoding="UTF-16"?>' + text).encode("utf-16"))
    assert "not UTF-8" in refusal(changed("robot", {"urdf": "arm.urdf"}), tmp_path)


def test_meshes_of_a_urdf_are_not_opened(tmp_path: Path) -> None:
    mesh = '<visual><geometry><mesh filename="file:///dev/zero"/></geometry></visual>'
    text = URDF.replace("<link name=", f'<link name="spare">{mesh}</link><link name=', 1)
    table = changed("robot", {"urdf_text": text})
    try:
        scene_from_table(table, name="hostile")
    except NospillError as error:
        assert len(str(error).splitlines()) == 1


@pytest.mark.parametrize("depth", [200, 5000])
def test_a_urdf_nested_very_deeply(depth: int) -> None:
    text = "<robot name='x'>" + "<link name='a'>" * depth + "</link>" * depth + "</robot>"
    refusal(changed("robot", {"urdf_text": text}))


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/null", "/proc/self/mem", "missing.csv", ".", "a\0b", ""])
@pytest.mark.parametrize("key", ["path", "robot"])
def test_files_that_are_none(name: str, key: str, tmp_path: Path) -> None:
    table = changed("path", {"type": "waypoints", "file": name}) if key == "path" else changed("robot", {"urdf": name})
    refusal(table, tmp_path)


def test_waypoints_from_a_device_that_never_ends(tmp_path: Path) -> None:
    """In a process that may have 1.5 GB: the answer must be a refusal, not the end of the memory."""
    (tmp_path / "tray.toml").write_text(tomli_w.dumps(changed("path", {"type": "waypoints", "file": "/dev/zero"})))
    script = """
        import resource, sys
        from nospill.errors import NospillError
        from nospill.scenario import read_scenario
        resource.setrlimit(resource.RLIMIT_AS, (1_500_000_000, 1_500_000_000))
        try:
            read_scenario(sys.argv[1])
        except NospillError as error:
            print("refused", error)
    """
    done = run_python("-c", textwrap.dedent(script), str(tmp_path / "tray.toml"))
    assert done.stdout.startswith("refused")


@pytest.mark.slow
def test_ten_megabytes_of_waypoints_are_refused(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(1000, 3))
    (tmp_path / "way.csv").write_text("\n".join(",".join(map(repr, row)) for row in points.tolist() * 180))
    assert (tmp_path / "way.csv").stat().st_size > 10e6
    message = refusal(changed("path", {"type": "waypoints", "file": "way.csv"}), tmp_path)
    assert "180000 points, at most 20000 are allowed" in message


def test_a_plan_writes_into_its_folder_and_nowhere_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Everything around the output folder is as it was, after a refusal too."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tray.toml").write_text(tomli_w.dumps(changed("cargo.0.name", "../../stolen")))
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(SystemExit) as caught:
        app(["plan", "tray.toml", "-o", "out"])
    assert caught.value.code == 2 and len(capsys.readouterr().err.splitlines()) == 1
    assert sorted(place.name for place in tmp_path.rglob("*")) == ["notes.txt", "tray.toml"]
