"""Free waves in tapered cups, fully nonlinear: what the linear height misses where walls slope.

    python -m benchmarks.water.tapered

An ideal liquid in a cup whose wall has the radius R + z tan(angle), z from the rest level, flat bottom. It shares
nothing with `nospill.potential_flow`: the potential is a sum of solid harmonics, which meets its values on the surface
and the closed wall and bottom by least squares; surface and potential on it are Zernike polynomials of r over the
wall's radius at that height, so that the contact line goes up and down the slope. The state is carried on by classical
Runge-Kutta steps. For each angle and height it prints crest and trough over the first mode's amplitude and the change
of frequency, like `tests.potential_flow.test_free_waves` does of upright cups (angle 0 here).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq

GRAVITY = 9.80665
RADIUS, DEPTH = 0.035, 0.049
ANGLES = (-5.0, 0.0, 5.0, 10.0)
"""deg, of the wall from the vertical; the cup is wider above where it is positive."""
HEIGHTS = (0.002, 0.005, 0.007)
DIAMETERS, CIRCLES, DEGREE = 5, 4, 32
STEP, FADING = 3e-3, 10


@dataclass(frozen=True)
class Cup:
    """A cup's slope and its points: (P,) of the surface as parts of the wall's radius and azimuths, with the basis.

    Attributes:
        slope: tangent of the wall's angle.
        sigma, azimuth, weight: (P,) points of the surface and their weights.
        basis, radial, around: (P, J) polynomials, their derivatives by sigma and by the azimuth.
        edge: (J, 2) polynomials at the wall, azimuth 0 and pi.
        orders: (J,) nodal diameters.
        floor: (P, L) derivatives of the harmonics by z on the bottom.
        kept: (J,) part of each polynomial that a step keeps: the shortest ones, which run away at a sloping wall, fade.
    """

    slope: float
    sigma: np.ndarray
    azimuth: np.ndarray
    weight: np.ndarray
    basis: np.ndarray
    radial: np.ndarray
    around: np.ndarray
    edge: np.ndarray
    orders: np.ndarray
    floor: np.ndarray
    kept: np.ndarray

    def wall(self, z: np.ndarray) -> np.ndarray:
        """Radius of the wall at a height, m."""
        return RADIUS + self.slope * z


def cup(angle: float) -> Cup:
    """A cup of an angle, deg."""
    node, weight = np.polynomial.legendre.leggauss(10)
    rings, turns = (node + 1) / 2, math.pi * (np.arange(12) + 0.5) / 12
    sigma, azimuth = np.repeat(rings, 12), np.tile(turns, 10)
    shapes = [(m, zernike(m, n)) for m in range(DIAMETERS + 1) for n in range(CIRCLES + 1)]
    parts = [(p(sigma), p.deriv()(sigma), np.cos(m * azimuth), -m * np.sin(m * azimuth)) for m, p in shapes]
    slope = math.tan(math.radians(angle))
    degree = np.array([m + 2 * n for m in range(DIAMETERS + 1) for n in range(CIRCLES + 1)])
    bottom = sigma * (RADIUS - slope * DEPTH)
    return Cup(
        slope=slope,
        sigma=sigma,
        azimuth=azimuth,
        weight=np.repeat(weight * rings, 12),
        basis=np.stack([value * c for value, _, c, _ in parts], axis=1),
        radial=np.stack([change * c for _, change, c, _ in parts], axis=1),
        around=np.stack([value * s for value, _, _, s in parts], axis=1),
        edge=np.array([[p(1.0), p(1.0) * (-1) ** m] for m, p in shapes]),
        orders=np.array([m for m, _ in shapes]),
        floor=harmonics(bottom, np.full_like(bottom, -DEPTH), azimuth)[3],
        kept=np.exp(-((degree / degree.max()) ** FADING)),
    )


def zernike(m: int, n: int) -> np.polynomial.Polynomial:
    """Radial polynomial of m nodal diameters and degree m + 2 n, 1 at the wall."""
    terms = np.zeros(m + 2 * n + 1)
    for k in range(n + 1):
        over = math.factorial(k) * math.factorial(m + n - k) * math.factorial(n - k)
        terms[m + 2 * (n - k)] = (-1) ** k * math.factorial(m + 2 * n - k) / over
    return np.polynomial.Polynomial(terms)


def harmonics(r: np.ndarray, z: np.ndarray, azimuth: np.ndarray) -> tuple[np.ndarray, ...]:
    """Solid harmonics (P, L) with cos(m azimuth) about the middle of the depth, and their gradients.

    By r, azimuth (over r) and z, lengths over the radius.
    """
    r, z = r / RADIUS, (z + DEPTH / 2) / RADIUS
    own: dict[tuple[int, int], np.ndarray] = {}
    for m in range(DIAMETERS + 2):
        own[m, m] = r**m / (2.0**m * math.factorial(m))
        for degree in range(m + 1, DEGREE + 1):
            before = own.get((degree - 2, m), np.zeros_like(r))
            own[degree, m] = ((2 * degree - 1) * z * own[degree - 1, m] - (r**2 + z**2) * before) / (degree**2 - m**2)
    none, columns = np.zeros_like(r), []
    for m in range(DIAMETERS + 1):
        for degree in range(m, DEGREE + 1):
            more = -own.get((degree - 1, m + 1), none)
            less = own.get((degree - 1, m - 1), none) if m else more
            up = own.get((degree - 1, m), none)
            c, s = np.cos(m * azimuth), np.sin(m * azimuth)
            columns.append((own[degree, m] * c, (more + less) / 2 * c, -(less - more) / 2 * s, up * c))
    return tuple(np.stack(part, axis=1) for part in zip(*columns, strict=True))


def rates(own: Cup, state: np.ndarray) -> np.ndarray:
    """Rates (2, J) of surface and potential on it from their coefficients (2, J)."""
    z, psi = own.basis @ state[0], own.basis @ state[1]
    rise, turn = own.radial @ state[0], own.around @ state[0]
    radius = own.wall(z)
    value, outward, across, up = harmonics(own.sigma * radius, z, own.azimuth)
    node, _ = np.polynomial.legendre.leggauss(12)
    turns = own.azimuth[:12]
    top = np.cos(np.outer(turns, own.orders)) @ (own.edge[:, 0] * state[0])
    height = (-DEPTH + np.outer(node + 1, top + DEPTH) / 2).ravel()
    _, wall_out, _, wall_up = harmonics(own.wall(height), height, np.tile(turns, len(node)))
    system = np.concatenate([value, wall_out - own.slope * wall_up, own.floor])
    size = np.linalg.norm(system, axis=0)
    wanted = np.concatenate([psi, np.zeros(len(system) - len(psi))])
    solved = lstsq(system / size, wanted, cond=1e-10, lapack_driver="gelsy", check_finite=False)
    assert solved is not None  # scipy's own types allow for None
    share = solved[0] / size
    u, v, w = outward @ share / RADIUS, across @ share / RADIUS, up @ share / RADIUS
    moved = w * (1 + rise * own.sigma * own.slope / radius) - u * rise / radius - v * turn / (own.sigma * radius)
    change = (w + u * own.sigma * own.slope) * moved - GRAVITY * z - (u**2 + v**2 + w**2) / 2
    return project(own, np.stack([moved, change], axis=1))


def project(own: Cup, values: np.ndarray) -> np.ndarray:
    """Coefficients (k, J) of values (P, k)."""
    root = np.sqrt(own.weight)[:, None]
    return np.linalg.lstsq(root * own.basis, root * values, rcond=None)[0].T


def first_mode(own: Cup) -> tuple[float, np.ndarray]:
    """Frequency of the slowest mode, rad/s, and its coefficients (J,), 1 at the wall."""
    tiny, count = 1e-9, len(own.orders)
    columns = [rates(own, np.stack([np.zeros(count), tiny * unit]))[0] / tiny for unit in np.eye(count)]
    odd = np.flatnonzero(own.orders == 1)
    found = np.linalg.eig(GRAVITY * np.array(columns).T[np.ix_(odd, odd)])
    squares, shapes = np.real(found.eigenvalues), np.real(found.eigenvectors)
    slowest = int(np.argmax(np.abs(shapes[0])))  # the most like a plane; what the harmonics cannot follow is slower yet
    shape = np.zeros(count)
    shape[odd] = shapes[:, slowest]
    return math.sqrt(squares[slowest]), shape / (own.edge[:, 0] @ shape)


def free_wave(own: Cup, shape: np.ndarray, height: float, duration: float) -> np.ndarray:
    """Coefficients (m, J) of the surface at steps from rest with the mode that high."""
    state, found = np.stack([height * shape, np.zeros_like(shape)]), []
    for _ in range(round(duration / STEP)):
        found.append(state[0])
        k1 = rates(own, state)
        k2 = rates(own, state + STEP / 2 * k1)
        k3 = rates(own, state + STEP / 2 * k2)
        k4 = rates(own, state + STEP * k3)
        state = own.kept * (state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
        if not np.all(np.isfinite(state)) or np.abs(own.basis @ state[0]).max() > RADIUS:
            break
    return np.array(found)


def figures(own: Cup, frequency: float, shape: np.ndarray, height: float) -> str:
    """Crest and trough over the amplitude and the change of frequency in the first 1.05 s, as cells of a table."""
    wave = free_wave(own, shape, height, 1.05)
    if len(wave) < round(1.05 / STEP):
        return f"breaks down at {STEP * len(wave):.2f} s"
    course, ends = project_on(own, shape, wave), wave @ own.edge
    t = STEP * np.arange(len(wave))
    down = np.flatnonzero((course[:-1] > 0) != (course[1:] > 0))
    zeros = t[down] + STEP * course[down] / (course[down] - course[down + 1])
    half = (zeros[-1] - zeros[0]) / (len(zeros) - 1)
    crests, troughs, swings = [], [], []
    for number in range(1, int((t[-1] - half / 2) / half) + 1):
        part, up = np.abs(t - number * half) < half / 2, number % 2
        crests.append(np.max(ends[part, up]))
        troughs.append(-np.min(ends[part, 1 - up]))
        swings.append(np.max(np.abs(course[part])))
    over = [float(np.mean(values) / np.mean(swings)) for values in (crests, troughs)]
    return f"{over[0]:.3f}, {over[1]:.3f}, {1e2 * (math.pi / half / frequency - 1):+.2f} %"


def project_on(own: Cup, shape: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """Amplitude (m,) of the first mode in surfaces (m, J)."""
    mode = own.basis @ shape
    return (wave @ own.basis.T) @ (own.weight * mode) / (own.weight @ mode**2)


def main() -> None:
    """Print the table."""
    print("| angle | frequency | " + " | ".join(f"{1e3 * height:g} mm" for height in HEIGHTS) + " |")
    print("|---|---|" + "---|" * len(HEIGHTS))
    for angle in ANGLES:
        own = cup(angle)
        frequency, shape = first_mode(own)
        cells = [figures(own, frequency, shape, height) for height in HEIGHTS]
        print(f"| {angle:g} deg | {frequency / 2 / math.pi:.4f} Hz | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
