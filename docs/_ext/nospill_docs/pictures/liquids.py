"""Pictures of the liquid: its modes, the masses that replace them, and its height."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from nospill.plots.style import BLACK, BLUE, DARK_RED, GREEN, GREY, ORANGE, PURPLE, RED
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import SloshModes
from nospill.simulation.simulate import simulate_slosh
from nospill_docs.pictures.paper import GLASS, LIQUID, arrow, note, sheet, sketch, words

_RADIUS, _LEVEL, _HEIGHT = 0.035, 0.049, 0.065
"""m; the cup of the published experiment."""


def _cup_modes(count: int) -> SloshModes:
    return Cylinder(_RADIUS, _HEIGHT).slosh_modes(LIQUIDS["water"], _LEVEL, count)


def modes() -> Figure:
    """The first three modes of a cup from the side, and the masses that stand for them."""
    figure = sheet(2.75)
    found = _cup_modes(3)
    section = Cylinder(_RADIUS, _HEIGHT).section(_LEVEL)
    across = np.linspace(-1.0, 1.0, 161)
    points = np.column_stack([_RADIUS * across, np.zeros_like(across)])
    for number, mode in enumerate(found.oscillators[:3]):
        axes = sketch(figure, (0.235 * number, 0.0, 0.235, 0.9), (-1.25, 1.25), (-0.75, 2.35))
        rise = 0.32 * section.mode_shape(mode.wave_number, points, 0)
        level = _LEVEL / _RADIUS
        for side, dashes in ((-1.0, (0, (4, 1.5))), (1.0, "-")):
            axes.plot(
                across, level + side * rise, color=BLUE, linewidth=1.8 if side > 0 else 1.0, linestyle=dashes, zorder=4
            )
        water = np.vstack([[-1.0, 0.0], [1.0, 0.0], np.column_stack([across, level + rise])[::-1]])
        axes.add_patch(Polygon(water, facecolor=LIQUID, zorder=1))
        _wall(axes, np.array([[1.0, 0.0], [1.0, _HEIGHT / _RADIUS + 0.25]]))
        share = 100 * mode.mass / found.liquid_mass
        figure.text(
            0.1175 + 0.235 * number,
            0.93,
            f"mode {mode.number}: {mode.frequency / (2 * np.pi):.2f} Hz",
            ha="center",
            size=9,
            weight="bold",
        )
        words(axes, (0.0, -0.4), f"{share:.1f} % of the liquid", ha="center", size=8.5)
    axes = sketch(figure, (0.72, 0.0, 0.28, 0.9), (-1.45, 1.75), (-0.75, 2.35))
    figure.text(0.85, 0.93, "what stands for them", ha="center", size=9, weight="bold")
    _wall(axes, np.array([[1.0, 0.0], [1.0, _HEIGHT / _RADIUS + 0.25]]))
    words(axes, (0.0, _LEVEL / _RADIUS + 0.3), "masses on springs", ha="center", size=8.5)
    beside = -np.inf
    for mode, size in zip(found.oscillators, (15, 8, 6), strict=True):
        height = mode.height / _RADIUS
        # The upper ones are so near to each other that their names would lie on one another.
        beside = max(height, beside + 0.19)
        _spring(axes, -1.0, -0.12, height)
        _spring(axes, 0.12, 1.0, height)
        axes.plot(0.0, height, "o", color=BLUE, markersize=size, zorder=5)
        words(axes, (1.08, beside), f"$H_{mode.number}$", size=8.5)
    axes.plot(0.0, found.fixed_height / _RADIUS, "s", color="#4A5560", markersize=15, zorder=5)
    words(axes, (0.26, found.fixed_height / _RADIUS - 0.02), "rest, $m_0$", size=8.5)
    words(axes, (0.0, -0.4), "water, radius 35 mm, 49 mm deep", ha="center", size=8.5)
    return figure


def _wall(axes: Axes, meridian: np.ndarray) -> None:
    """A vessel from the side: its meridian (n, 2) and its mirror image, and the bottom between them."""
    whole = np.vstack([meridian[::-1] * (-1.0, 1.0), meridian])
    axes.plot(*whole.T, color=GLASS, linewidth=2.2, solid_joinstyle="round", zorder=6)


def _spring(axes: Axes, start: float, end: float, height: float) -> None:
    x = np.linspace(start, end, 11)
    y = height + 0.06 * np.array([0, 0, 1, -1, 1, -1, 1, -1, 1, 0, 0])
    axes.plot(x, y, color=GREY, linewidth=0.9, zorder=3)


def paraboloid() -> Figure:
    """The first mode's mass on its paraboloid under an apparent gravity that leans, and the height at the wall."""
    figure = sheet(2.6)
    axes = sketch(figure, (0.0, 0.0, 0.46, 1.0), (-2.0, 2.2), (-0.35, 3.0))
    found = _cup_modes(1).oscillators[0]
    level, height, curvature = _LEVEL / _RADIUS, found.height / _RADIUS, found.stiffness * _RADIUS
    q = 0.36
    rise = found.surface_gain * q
    water = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, level + rise], [-1.0, level - rise]])
    axes.add_patch(Polygon(water, facecolor=LIQUID, zorder=1))
    axes.plot(*water[2:].T, color=BLUE, linewidth=1.8, zorder=3)
    axes.plot([-1.0, 1.0], [level, level], color=BLUE, linewidth=0.9, linestyle=(0, (4, 1.5)), zorder=3)
    _wall(axes, np.array([[1.0, 0.0], [1.0, 2.35]]))
    x = np.linspace(-0.75, 0.75, 80)
    axes.plot(x, height + 0.5 * curvature * x**2, color=BLACK, linewidth=1.4, zorder=4)
    axes.plot(q, height + 0.5 * curvature * q**2, "o", color=BLUE, markeredgecolor="white", markersize=12, zorder=6)
    arrow(axes, (0.0, height - 0.16), (q, height - 0.16), width=1.2)
    words(axes, (0.12, height - 0.34), "$q$")
    note(axes, (-0.5, height + 0.5 * curvature * 0.25), (-1.95, 0.7), "paraboloid,\n$P = \\omega_1^2/g$", size=8.5)
    arrow(axes, (1.12, level), (1.12, level + rise), width=1.2)
    words(axes, (1.2, level + 0.5 * rise), "$\\eta = C_1 q$")
    arrow(axes, (-1.5, 2.9), (-1.15, 2.05), color=RED, width=2.0)
    words(axes, (-1.95, 1.85), "apparent gravity", size=8.5, color=DARK_RED)
    heights = figure.add_axes((0.55, 0.17, 0.435, 0.71))
    t, tray = _surge()
    modes_20 = _height(t, tray, 20)
    heights.plot(t, 1e3 * modes_20, color=BLACK, linewidth=1.0, label="20 modes")
    heights.plot(t, 1e3 * _height(t, tray, 1), color=BLUE, linestyle=(0, (1.3, 1.3)), label="one mode")
    heights.plot(
        t, 1e3 * _height(t, tray, 1, corrected=True), color=ORANGE, linestyle=(0, (5, 1.6)), label="one, corrected"
    )
    heights.set_title("Height at the wall: surge of 80 mm in 0.6 s")
    heights.set_ylabel("height [mm]")
    heights.set_xlabel("time [s]")
    heights.set_xlim(0.0, float(t[-1]))
    heights.set_ylim(bottom=0.0)
    heights.axvspan(0.0, 0.6, color="#F0F0F0", zorder=0)
    heights.legend(loc="upper right", handlelength=2.2)
    return figure


def _surge(*, length: float = 0.08, duration: float = 0.6, rest: float = 0.6) -> tuple[np.ndarray, np.ndarray]:
    """Times (m,) s and positions (m, 3) m of a surge from rest to rest, a polynomial of degree seven."""
    t = np.arange(0.0, duration + rest + 1e-9, 0.001)
    s = np.clip(t / duration, 0.0, 1.0)
    x = length * (35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7)
    return t, np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])


def _height(t: np.ndarray, position: np.ndarray, modes: int, *, corrected: bool = False) -> np.ndarray:
    table = {
        "shape": "cylinder",
        "radius": _RADIUS,
        "height": 0.12,
        "liquid": "water",
        "liquid_height": _LEVEL,
    }
    still = np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1))
    return simulate_slosh(
        table, t, position, still, modes=modes, height="corrected" if corrected else "one-mode"
    ).height


def after_the_end() -> Figure:
    """A liquid left to itself: its height, and the bound that holds for all later time."""
    figure = sheet(2.3)
    axes = figure.add_axes((0.075, 0.19, 0.91, 0.68))
    mode = _cup_modes(1).oscillators[0]
    zeta = 0.03
    omega = mode.frequency
    fast = omega * np.sqrt(1.0 - zeta**2)
    t = np.linspace(0.0, 1.5, 900)
    start, rate = 0.0011, 0.035
    b = (rate + zeta * omega * start) / fast
    decay = np.exp(-zeta * omega * t)
    q = decay * (start * np.cos(fast * t) + b * np.sin(fast * t))
    speed = np.gradient(q, t)
    bound = mode.surface_gain * np.sqrt(q**2 + ((speed / omega + zeta * q) / (1.0 + zeta)) ** 2)
    axes.plot(t, 1e3 * mode.surface_gain * np.abs(q), color=BLUE, label="height at the wall")
    axes.plot(
        t,
        1e3 * bound,
        color=ORANGE,
        linestyle=(0, (5, 1.6)),
        label="bound taken at each instant, $C\\,\\sqrt{A^2 + D^2}$",
    )
    limit = 1e3 * bound[0]
    axes.axhline(limit, color=RED, linewidth=1.2)
    axes.annotate(
        "bound at the end of the motion: nothing later is higher",
        (1.5, limit),
        xytext=(-2, 2),
        textcoords="offset points",
        ha="right",
        va="bottom",
        size=8,
        color=DARK_RED,
    )
    axes.set_xlabel("time after the end of the motion [s]")
    axes.set_ylabel("height [mm]")
    axes.set_title("After the end: damping ratio 0.03, so that it is seen")
    axes.set_xlim(0.0, 1.5)
    axes.set_ylim(0.0, 1.22 * limit)
    axes.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 0.83))
    return figure


def closed_form() -> Figure:
    """The simulation of a sudden, constant acceleration against the closed form, and the model's range."""
    figure = sheet(2.7)
    step, shallow = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.075, right=0.985, top=0.88, bottom=0.17, wspace=0.24)
    t = np.arange(0.0, 1.2001, 0.001)
    pull = 0.4
    position = np.column_stack([0.5 * pull * t**2, 0.0 * t, 0.0 * t])
    step.plot(t, 1e3 * _height(t, position, 1), color=BLUE, linewidth=2.4, label="simulation, one mode")
    mode = _cup_modes(1).oscillators[0]
    damped = mode.frequency * np.sqrt(1.0 - mode.damping**2)
    ring = np.exp(-mode.damping * mode.frequency * t) * (
        np.cos(damped * t) + mode.damping * mode.frequency / damped * np.sin(damped * t)
    )
    rest = mode.surface_gain * pull / mode.frequency**2
    step.plot(
        t, 1e3 * rest * np.abs(1.0 - ring), color=BLACK, linewidth=1.0, linestyle=(0, (4, 3)), label="linear oscillator"
    )
    step.axhline(1e3 * rest, color=GREY, linewidth=0.9, linestyle=(0, (1.3, 1.3)))
    step.set_title("A jump of the acceleration to 0.4 m/s²")
    step.set_xlabel("time [s]")
    step.set_ylabel("height at the wall [mm]")
    step.set_xlim(0.0, 1.2)
    step.set_ylim(0.0, 1e3 * rest * 3.1)
    step.legend(loc="upper right")
    depth = np.linspace(0.1, 3.0, 120)
    for radius, colour, dashes in ((0.02, PURPLE, (0, (1.3, 1.3))), (0.035, BLUE, "-"), (0.06, GREEN, (0, (5, 1.6)))):
        wave = 1.8412 / radius
        shallow.plot(
            depth,
            np.sqrt(9.80665 * wave * np.tanh(wave * depth * radius)) / (2 * np.pi),
            color=colour,
            linestyle=dashes,
        )
        shallow.annotate(
            f"R = {1e3 * radius:g} mm",
            (3.0, np.sqrt(9.80665 * wave) / (2 * np.pi)),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            size=8,
            color="#333333",
        )
    shallow.set_title("First frequency of a cup")
    shallow.set_xlabel("depth over radius [1]")
    shallow.set_ylabel("frequency [Hz]")
    shallow.set_xlim(0.0, 3.0)
    shallow.set_ylim(0.0, 5.6)
    return figure
