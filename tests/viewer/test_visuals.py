"""Meshes from a URDF file: found, placed, refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

pytest.importorskip("viser", reason="viser is not installed")

from nospill.drawing.timeline import Film
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.viewer.live import running_server, show_plans
from nospill.viewer.meshes import load_visuals

ROBOT = load_robot("comau-smart-six")


def urdf_with(folder: Path, visuals: dict[str, str]) -> Path:
    """The arm's own URDF with a <visual> in some links."""
    text = ROBOT.urdf
    for link, visual in visuals.items():
        assert f'<link name="{link}"/>' in text
        text = text.replace(f'<link name="{link}"/>', f'<link name="{link}"><visual>{visual}</visual></link>')
    path = folder / "arm.urdf"
    path.write_text(text)
    return path


def mesh_of(name: str, scale: str = "") -> str:
    return f'<origin xyz="0 0 0.1"/><geometry><mesh filename="{name}" {scale}/></geometry>'


@pytest.mark.parametrize("name", ["meshes/link.stl", "package://arm_description/meshes/link.stl", "file://{}"])
def test_meshes_are_found_scaled_and_placed(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "arm_description"
    (folder / "meshes").mkdir(parents=True)
    trimesh.creation.box(extents=(100, 200, 300)).export(folder / "meshes" / "link.stl")
    mesh = mesh_of(name.format(folder / "meshes" / "link.stl"), 'scale="0.001 0.001 0.002"')
    primitives = {
        "link_2": '<geometry><box size="0.1 0.2 0.3"/></geometry>',
        "link_3": '<origin rpy="0 1.5707963 0"/><geometry><cylinder radius="0.05" length="0.4"/></geometry>',
        "link_4": '<geometry><sphere radius="0.05"/></geometry>',
        "link_5": "<geometry><capsule/></geometry>",
    }
    found = load_visuals(urdf_with(folder, {"link_1": mesh, **primitives}), ROBOT)
    assert found.missing == ()
    assert found.meshes is not None
    assert set(found.meshes) == {"link_1", "link_2", "link_3", "link_4"}
    assert found.meshes["link_1"].bounds == pytest.approx(np.array([[-0.05, -0.1, -0.2], [0.05, 0.1, 0.4]]), abs=1e-6)
    assert found.meshes["link_2"].extents == pytest.approx([0.1, 0.2, 0.3])
    assert found.meshes["link_3"].extents[0] == pytest.approx(0.4)


def test_meshes_are_shown_in_place_of_drawn_links(tmp_path: Path, tilting_film: Film) -> None:
    trimesh.creation.box(extents=(0.1, 0.1, 0.2)).export(tmp_path / "link.stl")
    found = load_visuals(urdf_with(tmp_path, {"link_1": mesh_of("link.stl")}), ROBOT)
    with running_server(port=0) as server:
        show_plans(server, [tilting_film], visuals=found)
        names = list(server.scene._handle_from_node_name)
    assert [name for name in names if name.endswith("joint_1/mesh")]
    assert [name.rpartition("/joint_6/")[2] for name in names if name.endswith("flange_fixed/body")]
    assert not [name for name in names if name.endswith(("joint_1/body", "joint_2/body", "arm/body"))]


def test_missing_meshes_are_named_and_links_drawn(tmp_path: Path) -> None:
    found = load_visuals(urdf_with(tmp_path, {"link_1": mesh_of("package://nowhere/a.stl")}), ROBOT)
    assert found.meshes is None
    assert found.missing == ("package://nowhere/a.stl",)
    assert load_visuals(urdf_with(tmp_path, {}), ROBOT).meshes is None


def test_what_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_visuals(tmp_path / "none.urdf", ROBOT)
    (tmp_path / "link.stl").write_text("solid nonsense")
    with pytest.raises(ScenarioError, match=r"link\.stl cannot be read"):
        load_visuals(urdf_with(tmp_path, {"link_1": mesh_of("link.stl")}), ROBOT)
    with pytest.raises(ScenarioError, match=r"box cannot be read|numbers"):
        load_visuals(urdf_with(tmp_path, {"link_1": '<geometry><box size="1 2"/></geometry>'}), ROBOT)
    other = tmp_path / "other.urdf"
    other.write_text(ROBOT.urdf.replace('xyz="0 0 0.590"', 'xyz="0 0 0.690"'))
    with pytest.raises(ScenarioError, match="URDF of the same arm"):
        load_visuals(other, ROBOT)
