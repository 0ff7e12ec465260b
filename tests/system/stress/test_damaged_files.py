"""Readers fed with noise: whatever a file holds, it is read or refused in one line of nospill's own errors."""

from __future__ import annotations

import json
import shutil
import tempfile
import tomllib
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from nospill.errors import NospillError, PlanFolderError
from nospill.export import EXPORTERS
from nospill.motion.trajectory import read_trajectory
from nospill.paths.waypoint_files import read_waypoints
from nospill.plans import loading
from nospill.plans.handover import hand_over, read_samples
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.scenario.examples import EXAMPLES, example_path
from nospill.simulation.cup_file import read_cup
from nospill.simulation.motion_file import read_heights, read_motion

QUICK = settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

NOISE = st.one_of(
    st.binary(max_size=30),
    st.text(max_size=20).map(lambda text: text.encode("utf-8", "surrogatepass")),
    st.sampled_from(
        [b"\x00", b"\xff\xfe", b"nan", b"1e999", b"-", b'"', b"[[", b"\r", b"9" * 400, b"= inf\n", b"\x1a"]
    ),
)

LONGEST = 1500
"""Characters of a message. Plan folders whose JSON is not UTF-8 are beyond it, which a test below expects."""

WAYPOINTS = b"x,y,z\n0.1,0.2,0.3\n0.2,0.2,0.3\n0.3,0.1,0.4\n"
MOTION = b"t_s,x_m,y_m,z_m,qx,qy,qz,qw\n" + b"".join(b"%d,0,0,0,0,0,0,1\n" % row for row in range(20))
HEIGHTS = b"t_s,height_mm\n" + b"".join(b"%d,0.%d\n" % (row, row) for row in range(20))
CUP = b'name = "c"\nshape = "cylinder"\nradius = "35 mm"\nheight = "99 mm"\nliquid = "water"\nliquid_height = "49 mm"\n'


def damaged(content: bytes, noise: bytes, at: int, cut: int) -> bytes:
    """Noise put into the content somewhere, some of it cut out there."""
    at %= len(content) + 1
    return content[:at] + noise + content[at + cut :]


def read_or_refused(reader: Callable[[Path], object], place: Path) -> None:
    """Only nospill's own errors come out, in one line."""
    try:
        reader(place)
    except NospillError as error:
        assert len(str(error).splitlines()) == 1
        assert len(str(error)) < LONGEST or "damaged" in str(error)


@pytest.mark.parametrize(
    ("reader", "content", "name"),
    [
        (read_waypoints, WAYPOINTS, "way.csv"),
        (read_motion, MOTION, "motion.csv"),
        (read_heights, HEIGHTS, "heights.csv"),
        (read_cup, CUP, "cup.toml"),
    ],
    ids=["waypoints", "motion", "heights", "cup"],
)
@given(noise=NOISE, at=st.integers(0, 10_000), cut=st.integers(0, 40))
@example(noise=b"", at=0, cut=10_000)
@QUICK
def test_small_files(
    reader: Callable[[Path], object], content: bytes, name: str, noise: bytes, at: int, cut: int
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, name)
        place.write_bytes(damaged(content, noise, at, cut))
        read_or_refused(reader, place)


@given(name=st.sampled_from(sorted(EXAMPLES)), noise=NOISE, at=st.integers(0, 10_000), cut=st.integers(0, 60))
@QUICK
def test_scenarios(name: str, noise: bytes, at: int, cut: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "tray.toml")
        place.write_bytes(damaged(example_path(name).read_bytes(), noise, at, cut))
        read_or_refused(read_scenario, place)


@given(
    name=st.sampled_from(["scenario.toml", "trajectory.csv", "certificate.json", "summary.json"]),
    noise=NOISE,
    at=st.integers(0, 100_000),
    cut=st.integers(0, 200),
)
@QUICK
def test_plan_folders(saved: Path, name: str, noise: bytes, at: int, cut: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "plan")
        shutil.copytree(saved, copy)
        (copy / name).write_bytes(damaged((copy / name).read_bytes(), noise, at, cut))
        read_or_refused(load_plan, copy)


def trees() -> st.SearchStrategy[object]:
    """Any JSON."""
    leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6)
    return st.recursive(
        leaves, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner), max_leaves=6
    )


@pytest.mark.slow
def test_tables_of_a_plan_folder_that_say_something_else(saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loading, "read_trajectory", cache(loading.read_trajectory))  # the samples are as they were
    originals = {name: json.loads((saved / name).read_text()) for name in ("certificate.json", "summary.json")}

    @given(st.data())
    @settings(max_examples=80, deadline=None)
    def run(data: st.DataObject) -> None:
        name = data.draw(st.sampled_from(sorted(originals)))
        table = json.loads(json.dumps(originals[name]))
        holder: dict = table
        key = data.draw(st.sampled_from(sorted(holder)))
        if isinstance(holder[key], dict) and holder[key] and data.draw(st.booleans()):
            holder, key = holder[key], data.draw(st.sampled_from(sorted(holder[key])))
        elif isinstance(holder[key], list) and holder[key] and isinstance(holder[key][0], dict):
            holder = holder[key][0]
            key = data.draw(st.sampled_from(sorted(holder)))
        holder[key] = data.draw(trees())
        (saved / name).write_text(json.dumps(table))
        try:
            read_or_refused(load_plan, saved)
        finally:
            (saved / name).write_text(json.dumps(originals[name]))

    run()


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(EXPORTERS))
def test_exported_files(small_plan: Plan, written: dict[str, bytes], name: str, tmp_path: Path) -> None:
    if name not in written:
        pytest.skip(f"{name} is no single file, or not written for this plan")
    place = tmp_path / f"out{EXPORTERS[name].suffixes[0]}"

    # a function of its own: what fails is printed with its arguments, and a plan among them fills the page
    @given(noise=NOISE, at=st.integers(0, 100_000), cut=st.integers(0, 200))
    @settings(max_examples=15, deadline=None)
    def run(noise: bytes, at: int, cut: int) -> None:
        place.write_bytes(damaged(written[name], noise, at, cut))
        read_or_refused(lambda file: read_samples(EXPORTERS[name], file, small_plan.scene), place)

    run()


@pytest.fixture(scope="module")
def written(small_plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Every exported file of the plan that is one file."""
    found: dict[str, bytes] = {}
    for name, exporter in EXPORTERS.items():
        place = tmp_path_factory.mktemp("out") / f"out{exporter.suffixes[0]}"
        with suppress(NospillError):
            hand_over(small_plan, exporter, place)
            if place.is_file():
                found[name] = place.read_bytes()
    return found


def test_a_plan_folder_that_is_not_text_is_refused_briefly(saved: Path) -> None:
    content = (saved / "certificate.json").read_bytes()
    (saved / "certificate.json").write_bytes(b"\x80" + content)
    with pytest.raises(NospillError) as caught:
        load_plan(saved)
    assert len(str(caught.value)) < LONGEST


@pytest.mark.parametrize(
    ("reader", "content"),
    [(read_waypoints, WAYPOINTS), (read_motion, MOTION), (read_heights, HEIGHTS)],
    ids=["waypoints", "motion", "heights"],
)
def test_an_endless_cell_is_refused_briefly(reader: Callable[[Path], object], content: bytes, tmp_path: Path) -> None:
    (tmp_path / "long.csv").write_bytes(content + b"9" * 5000 + b",0" * (content.splitlines()[0].count(b",")))
    with pytest.raises(NospillError) as caught:
        reader(tmp_path / "long.csv")
    assert len(str(caught.value)) < LONGEST


def test_trajectories_of_nothing(tmp_path: Path) -> None:
    for content in (b"", b"\n", b"t_s\n", b"\xff", b",,,\n1,2,3\n"):
        (tmp_path / "trajectory.csv").write_bytes(content)
        with pytest.raises(NospillError):
            read_trajectory(tmp_path / "trajectory.csv")


def test_examples_are_what_they_were() -> None:
    """The tests above leave the bundled files alone."""
    for name in EXAMPLES:
        assert tomllib.loads(example_path(name).read_text(encoding="utf-8"))


@pytest.mark.parametrize("counts", [{"ldl": 10**12}, {"ldl": -1}, {"ldl": "many"}, {"ldl": 1.5}, None])
def test_counts_that_would_fill_the_memory(saved: Path, tmp_path: Path, counts: object) -> None:
    copy = shutil.copytree(saved, tmp_path / "copy")
    table = json.loads((copy / "summary.json").read_text())
    (copy / "summary.json").write_text(json.dumps(table | {"linear_solvers": counts}))
    with pytest.raises(PlanFolderError, match=r"summary.json is damaged"):
        load_plan(copy)


def test_a_number_too_large_for_any_float(saved: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(saved, tmp_path / "copy")
    table = json.loads((copy / "summary.json").read_text())
    (copy / "summary.json").write_text(json.dumps(table | {"backoff": {"slip | all": 10**400}}))
    with pytest.raises(PlanFolderError, match=r"summary.json is damaged \(OverflowError"):
        load_plan(copy)
