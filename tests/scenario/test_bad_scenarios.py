"""Malformed scenarios: each file of bad_scenarios/ gives one clear line and exit code 2.

The first line of a file holds the expected fragments, separated by " | ". The rest is laid over `_valid.toml`: tables
key by key, lists of tables entry by entry, "(remove)" takes a key away. With "# whole file" on the second line it is
taken as it stands.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from nospill.errors import NospillError, ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.messages import faults_of
from nospill.scenario.sentences import report

FOLDER = Path(__file__).parent / "bad_scenarios"
CASES = sorted(file.stem for file in FOLDER.glob("*.toml") if not file.stem.startswith("_"))


def laid_over(base: Any, patch: Any) -> Any:
    if isinstance(base, dict) and isinstance(patch, dict):
        merged = {key: laid_over(base.get(key), entry) for key, entry in patch.items() if entry != "(remove)"}
        return {key: entry for key, entry in {**base, **merged}.items() if patch.get(key) != "(remove)"}
    if isinstance(base, list) and isinstance(patch, list) and patch and all(isinstance(entry, dict) for entry in patch):
        return [laid_over(old, new) for old, new in zip(base, patch, strict=False)] + base[len(patch) :]
    return patch


def scenario_text_of(case: str) -> str:
    text = (FOLDER / f"{case}.toml").read_text(encoding="utf-8")
    if text.splitlines()[1:2] == ["# whole file"]:
        return text
    base = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
    patch = tomllib.loads(text)
    if patch.get("path", {}) and isinstance(patch["path"], dict) and "type" in patch["path"]:
        base["path"] = {}  # another type of path: nothing of the valid one remains
    return tomli_w.dumps(laid_over(base, patch))


def refusal(path: Path | str) -> str:
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path)
    error = caught.value
    assert isinstance(error, NospillError) and error.exit_code == 2
    assert error.__cause__ is None  # nothing foreign is chained to it
    message = str(error)
    assert len(message.splitlines()) == 1 and len(message) < 500
    for foreign in ("pydantic", "Traceback", "Input should be", "Value error", "validation error", "np.float"):
        assert foreign not in message
    return message


@pytest.mark.parametrize("count", [501, 20_000])
def test_too_many_objects_are_refused_before_they_are_compared(count: int) -> None:
    table = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
    table["cargo"] = [table["cargo"][0] | {"name": f"c{index}"} for index in range(count)]
    with pytest.raises(ScenarioError, match="cargo has more than 500 entries; at most 500 are planned for") as caught:
        scene_from_table(table, name="crowded")
    assert len(str(caught.value)) < 500


def test_the_valid_scenario_is_valid() -> None:
    assert len(read_scenario(FOLDER / "_valid.toml").cargo) == 2


def test_there_are_enough_of_them() -> None:
    assert len(CASES) >= 45


@pytest.mark.parametrize("case", CASES)
def test_bad_scenario(case: str, tmp_path: Path) -> None:
    file = tmp_path / "tray.toml"
    file.write_text(scenario_text_of(case), encoding="utf-8")
    message = refusal(file)
    assert message.startswith(f"{file}: ")
    text = message.removeprefix(f"{file}: ")
    expected = (FOLDER / f"{case}.toml").read_text(encoding="utf-8").splitlines()[0].removeprefix("# expect: ")
    for fragment in expected.split(" | "):
        assert fragment in text


def test_missing_file_names_the_nearest_example() -> None:
    assert 'no such file, and no bundled example of that name; did you mean "matrix-liquid"?' in refusal("matrix-liqid")
    assert "a bundled example (matrix-liquid, matrix-rigid" in refusal("/no/such/file.toml")
    assert "names no scenario" in refusal("")
    assert "cannot be read: embedded null byte" in refusal("a\0b") or "no such file" in refusal("a\0b")


def test_folder_and_device(tmp_path: Path) -> None:
    assert f"{tmp_path}: is a folder; name the scenario file in it" == refusal(tmp_path)
    assert "is not a regular file" in refusal("/dev/null")


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (b'name = "caf\xe9"\n', "is not UTF-8 text (byte 12); save it as UTF-8"),
        (b"\x00\x01\x02", "is not valid TOML"),
        (b"a = " + b"[" * 100_000, "nested too deeply"),
        (b"a = " + b"9" * 10_000, "cannot be read"),
        (b"#" * 10_000_001, "is too large (10000001 bytes; at most"),
        (b'a = "x"\r\n[robot]\r\nmodel = \'x', "is not valid TOML"),
    ],
    ids=["latin-1", "binary", "deep", "long number", "large", "windows lines"],
)
def test_content_that_is_no_scenario(content: bytes, fragment: str, tmp_path: Path) -> None:
    file = tmp_path / "tray.toml"
    file.write_bytes(content)
    assert fragment in refusal(file)


@pytest.mark.parametrize(
    ("csv", "fragment"),
    [
        ("x,y,z\n0.6,0,1.2\n0.6,oops,1.2\n", 'line 3: "oops" is not a number'),
        ("0.6,0,1.2\n0.6,nan,1.2\n", 'line 2: "nan" is not a finite number'),
        ("x,y,z\n0.6,0\n", "line 2: 2 columns"),
        ("a,b,c\n0.6,0,1\n", "is not known; columns are x, y, z"),
        ("", "0 waypoints"),
    ],
)
def test_bad_waypoint_files(csv: str, fragment: str, tmp_path: Path) -> None:
    table = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
    table["path"] = {"type": "waypoints", "file": "way.csv"}
    (tmp_path / "way.csv").write_text(csv, encoding="utf-8")
    (tmp_path / "tray.toml").write_text(tomli_w.dumps(table), encoding="utf-8")
    message = refusal(tmp_path / "tray.toml")
    assert "[path]: " in message and "way.csv" in message and fragment in message


def test_a_table_from_python_is_called_by_its_name() -> None:
    table = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
    table["cargo"][0]["radius"] = 10**5000
    with pytest.raises(
        ScenarioError, match=r'^mine: cargo "c1": radius \(a whole number of about 5001 digits\) is too large'
    ):
        scene_from_table(table, name="mine")
    table["cargo"][0]["radius"] = object()
    with pytest.raises(ScenarioError, match=r'^mine: cargo "c1": radius <object object at .* is not a length'):
        scene_from_table(table, name="mine")


def test_an_error_without_a_sentence_of_its_own_still_reads_well() -> None:
    from pydantic import ValidationError

    error = ValidationError.from_exception_data(
        "Scenario", [{"type": "bytes_type", "loc": ("tray", "friction"), "input": "x"}]
    )
    faults = faults_of(error, {"tray": {"friction": "x"}})
    assert str(report("tray.toml", faults)) == 'tray.toml: [tray]: friction "x" is not accepted here (bytes_type)'
