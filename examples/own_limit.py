"""A limit of one's own: the tray arrives slowly, whatever it does before."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

import nospill as ns


@dataclass(frozen=True)
class SlowArrival(ns.Constraint):
    """Speed of the tray's centre: at most `most` within `radius` of the goal, and more the farther away it is.

    Attributes:
        goal: x, y, z, m.
        most: m/s.
        radius: m.
        gain: by how much more for each metre farther away, 1/s.
    """

    goal: tuple[float, float, float]
    most: float
    radius: float = 0.10
    gain: float = 8.0

    name = "slow arrival"
    unit = "m/s"
    role = ns.Role.TRAY
    evaluated_at = ns.EvaluationPoint.TRAY

    def subjects(self, scene: ns.Scene) -> tuple[str, ...]:
        """Of what there is a row each."""
        return ("tray",)

    def budgets(self, sample: ns.Sample) -> tuple[tuple[ns.Cone, ...], ...]:
        """For each subject what has to hold at every instant: |demand| <= capacity."""
        assert sample.tray_position is not None and sample.tray_velocity is not None  # as they are at TRAY
        distance = ca.sqrt(ca.sumsqr(sample.tray_position - ca.DM(self.goal)) + 1e-8)  # smooth at the goal
        allowed = self.most + self.gain * ca.fmax(distance - self.radius, 0)
        return ((ns.Cone(sample.tray_velocity, allowed, self.most),),)


scene = ns.load("matrix-liquid")
x, y, z = scene.path.at([1.0])[0, :3].round(4).tolist()
limit = SlowArrival((x, y, z), most=0.15)
free, slow = ns.plan(scene), ns.plan(scene, constraints=[limit])
print(f"without it {free.duration:.3f} s, with it {slow.duration:.3f} s: {slow.limiting_text}")
print(f"the motion without it is judged by it: {ns.certify(free.trajectory, scene, constraints=[limit]).word}")

slow.plot("limits").savefig("own_limit.png", dpi=100)
slow.save("out/slow-arrival")
print(ns.load_plan("out/slow-arrival").message)
print(ns.load_plan("out/slow-arrival", constraints=[limit]).message)
