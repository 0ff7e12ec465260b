"""A film of the simulation: one camera that stands in the room, the tray and its load moving before it."""

from __future__ import annotations

import contextlib
import importlib
import os
import secrets
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from nospill.errors import MissingExtraError, PlanFolderError, ScenarioError
from nospill.plans.plan import Plan
from nospill.verify.engine import STEP, Stepper, build, mujoco, quiet
from nospill.verify.tray_motion import PlayedJoints, TrayMotion
from nospill.verify.verification import stage

SUFFIXES = (".mp4", ".gif")
"""Kinds of film."""

WIDTH, HEIGHT = 800, 608  # multiples of 16, which the film format wants
RATE = 25
"""Frames per second."""

_VIEW = np.array([-0.35, -1.0, 0.45])
"""From what is looked at to the camera, in the base frame."""


def require_film(path: Path) -> None:
    """Check, before any long work, that a film can be made.

    Raises:
        ScenarioError: a name that ends otherwise than in .mp4 or .gif. PlanFolderError: no folder for it.
        MissingExtraError: MuJoCo or imageio is not installed, or OpenGL cannot be had.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ScenarioError(f"--video {path}: a name that ends in {' or '.join(SUFFIXES)} is needed")
    if not path.parent.is_dir():
        raise PlanFolderError(f"cannot write {path}: there is no folder {path.parent}; make it first")
    _imageio()
    with _renderer(_graphics().MjModel.from_xml_string("<mujoco/>"), 16, 16):
        pass


def write_film(plan: Plan, joints: PlayedJoints, path: Path) -> int:
    """Simulate as `verify` does and film it in real time, settling left out.

    Args:
        plan: whose objects.
        joints: the motion of the robot.
        path: film to write (.mp4 or .gif), at once or not at all.

    Returns:
        The number of frames.

    Raises:
        As `require_film`; PlanFolderError when the disk refuses.
    """
    require_film(path)
    scene = stage(joints, plan.scene)
    camera = _scenery(scene.motion)
    model = build(scene.bodies, tray_size=plan.scene.tray.size, scenery=camera, looks=True)
    every = round(1.0 / (RATE * STEP))
    partial = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    frames = 0
    try:
        with quiet(mujoco()), _renderer(model, HEIGHT, WIDTH) as renderer, _writer(partial) as writer:
            stepper = Stepper(model, scene.bodies, scene.motion)
            while True:
                if stepper.index >= scene.settled and (stepper.index - scene.settled) % every == 0:
                    writer.append_data(_picture(renderer, model, stepper, scene.motion))
                    frames += 1
                if stepper.index + 1 >= len(scene.motion.t):
                    break
                stepper.step()
        partial.replace(path)
    except OSError as error:
        raise PlanFolderError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        partial.unlink(missing_ok=True)
    return frames


def _picture(renderer: Any, model: Any, stepper: Stepper, motion: TrayMotion) -> np.ndarray:
    """The scene at the stepper's instant, (height, width, 3): the room is put where the tray sees it."""
    engine, data = mujoco(), stepper.data
    back = motion.rotation[stepper.index].T
    room = model.body("room").mocapid[0]
    data.mocap_pos[room] = -back @ motion.position[stepper.index]
    engine.mju_mat2Quat(data.mocap_quat[room], np.ascontiguousarray(back).ravel())
    engine.mj_kinematics(model, data)
    engine.mj_camlight(model, data)
    renderer.update_scene(data, camera="camera")
    return renderer.render()


def _scenery(motion: TrayMotion) -> str:
    """Floor, light and camera in the base frame, the camera so far away that the whole way is in view."""
    low, high = np.min(motion.position, axis=0), np.max(motion.position, axis=0)
    middle, size = (low + high) / 2, float(np.linalg.norm(high - low)) + 0.5
    towards = _VIEW / np.linalg.norm(_VIEW)
    place = middle + 0.9 * size * towards
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    axes = " ".join(f"{value:.6f}" for value in (*right, *np.cross(towards, right)))
    x, y, z = (f"{value:.6f}" for value in place)
    floor = f"{middle[0]:.6f} {middle[1]:.6f} {low[2] - 0.25:.6f}"
    tiles = "".join(
        f'<geom type="box" contype="0" conaffinity="0" size="0.248 0.248 0.005" rgba="{0.86 if (i + j) % 2 else 0.7} '
        f'{0.86 if (i + j) % 2 else 0.7} {0.88 if (i + j) % 2 else 0.72} 1" pos="{i / 2} {j / 2} 0"/>'
        for i in range(-5, 6)
        for j in range(-5, 6)
    )
    return (
        f'<body name="room" mocap="true"><camera name="camera" pos="{x} {y} {z}" xyaxes="{axes}" fovy="45"/>'
        f'<light pos="{middle[0]:.6f} {middle[1]:.6f} {high[2] + 2.0:.6f}" dir="0 0.2 -1" directional="true" '
        f'diffuse="0.7 0.7 0.7"/><body pos="{floor}">{tiles}</body></body>'
    )


def _graphics() -> Any:
    """MuJoCo, told to draw without a screen where there is none; the choice counts when it is loaded first."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        os.environ.setdefault("MUJOCO_GL", "egl")
    return mujoco()


def _imageio() -> Any:
    try:
        return importlib.import_module("imageio.v2")
    except ImportError as error:
        raise MissingExtraError(
            f"imageio cannot be loaded ({error}); install it with: pip install 'nospill[verify]'"
        ) from error


@contextlib.contextmanager
def _renderer(model: Any, height: int, width: int) -> Iterator[Any]:
    engine = _graphics()
    try:
        renderer = engine.Renderer(model, height, width)
    except Exception as error:  # every OpenGL backend fails in its own way
        chosen = os.environ.get("MUJOCO_GL", "")
        raise MissingExtraError(
            f"a film needs OpenGL, which cannot be had here (MUJOCO_GL={chosen or 'not set'}: "
            f"{' '.join(str(error).split())[:160]}); without a screen set MUJOCO_GL=egl or MUJOCO_GL=osmesa, or leave "
            "--video out"
        ) from error
    try:
        yield renderer
    finally:
        renderer.close()


@contextlib.contextmanager
def _writer(path: Path) -> Iterator[Any]:
    library = _imageio()
    options = {"loop": 0, "duration": 1000 / RATE} if path.suffix.lower() == ".gif" else {"fps": RATE}
    with library.get_writer(path, **options) as writer:
        yield writer
