"""Who reads a table of joints, one line each: rate, unit, names, and what is played of it."""

from __future__ import annotations

from dataclasses import dataclass

from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError
from nospill.export.makers import maker_of
from nospill.motion.interpolation import QUINTIC_HERMITE, QUINTIC_SPLINE, Interpolation
from nospill.scene.scene import Scene

SAME_RATE = 1e-4
"""Part by which a rate may differ from one of a profile: 83.33 Hz are rows every 12 ms."""


@dataclass(frozen=True, slots=True)
class Profile:
    """One reader of a table.

    Attributes:
        name: key in the table.
        title: who reads it, in one line.
        maker: of the arm, as `makers.maker_of` names it; None for any.
        joints: numbers of joints that it has; empty for any.
        rates: rows a second that it takes, Hz, the usual one first; empty for any.
        unit: "rad" or "deg".
        names: name of a joint's column by its number from 0 (`{0}`) or from 1 (`{1}`); empty for the arm's own names.
        whole: whether speeds and accelerations are in it too; the reader then plays a quintic per segment.
        interface: by which the reader asks the arm, where that checks a command, of `interfaces.INTERFACES`.
    """

    name: str
    title: str
    maker: str | None = None
    joints: tuple[int, ...] = ()
    rates: tuple[float, ...] = ()
    unit: str = "rad"
    names: str = ""
    whole: bool = False
    interface: str = ""

    def caution(self, scene: Scene) -> str | None:
        """The sentence about checks of the interface that the certificate does not have, or None."""
        stated = None if scene.controller is None else scene.controller.interface
        if not self.interface or (stated is not None and stated.name == self.interface):
            return None
        return (
            f"what the interface checks of a command is not in the certificate; plan with [controller] interface = "
            f'"{self.interface}"'
        )

    @property
    def interpolation(self) -> Interpolation:
        """What the reader makes of the rows."""
        return QUINTIC_HERMITE if self.whole else QUINTIC_SPLINE

    def columns(self, scene: Scene) -> list[str]:
        """The header: time, positions, then speeds and accelerations where they are in it."""
        joints = scene.robot.joints
        named = [self.names.format(index, index + 1) if self.names else name for index, name in enumerate(joints)]
        units = (self.unit, f"{self.unit}_s", f"{self.unit}_s2") if self.whole else (self.unit,)
        return ["t_s", *(f"{name}_{unit}" for unit in units for name in named)]

    def reason_against(self, scene: Scene, rate: float) -> str | None:
        """The sentence that says why a scene cannot be written at a rate in Hz, or None."""
        count, maker = len(scene.robot.joints), maker_of(scene)
        if self.joints and count not in self.joints:
            wanted = " or ".join(map(str, self.joints))
            return f"profile {self.name} is for {wanted} joints; this arm has {count} joints; leave --profile out"
        if self.maker is not None and maker not in (None, self.maker):
            return (
                f"profile {self.name} is for arms of {self.maker}; {scene.robot.name} is one of {maker}; "
                "leave --profile out"
            )
        if self.rates and all(abs(rate / known - 1.0) > SAME_RATE for known in self.rates):
            rates = " or ".join(f"{known:.6g}" for known in self.rates)
            return f"rate is {rate:g} Hz; profile {self.name} is played at {rates} Hz; leave --rate out"
        return None


PLAIN = Profile("plain", "any program: positions, speeds and accelerations of every joint", whole=True)

PROFILES: dict[str, Profile] = {
    profile.name: profile
    for profile in (
        PLAIN,
        Profile(
            "franka",
            "a client of libfranka: one row each 1 ms",
            maker="Franka",
            joints=(7,),
            rates=(1000.0,),
            names="q_{0}",
            interface="fci",
        ),
        Profile(
            "servoj",
            "a client of ur_rtde or RTDE that calls servoJ each period",
            maker="Universal Robots",
            joints=(6,),
            rates=(500.0, 125.0),
            names="target_q_{0}",
        ),
        Profile(
            "rsi-4ms", "KUKA RSI, IPO_FAST: AK corrections each 4 ms", "KUKA", (6,), (250.0,), unit="deg", names="A{1}"
        ),
        Profile(
            "rsi-12ms",
            "KUKA RSI, IPO: AK corrections each 12 ms",
            "KUKA",
            (6,),
            (1000.0 / 12.0,),
            unit="deg",
            names="A{1}",
        ),
        Profile(
            "egm",
            "ABB EGM: joint references each 4 ms",
            maker="ABB",
            joints=(6, 7),
            rates=(250.0,),
            unit="deg",
            names="joint_{1}",
        ),
        Profile(
            "kinova",
            "Kinova Kortex, low-level servoing each 1 ms",
            maker="Kinova",
            joints=(6, 7),
            rates=(1000.0,),
            unit="deg",
            names="joint_{1}",
        ),
        Profile(
            "xarm",
            "UFACTORY set_servo_angle_j, a row each 4 ms",
            maker="UFACTORY",
            joints=(5, 6, 7),
            rates=(250.0, 200.0, 100.0),
            names="joint{1}",
        ),
    )
}
"""Every reader by its name."""


def profile_named(name: str) -> Profile:
    """The profile of a name.

    Raises:
        ScenarioError: there is none.
    """
    if name not in PROFILES:
        near = nearest(name, PROFILES, likeness=0.5)
        hint = f'; did you mean "{near}"?' if near else ""
        raise ScenarioError(f'csv: no profile "{name}"; there are {", ".join(PROFILES)}{hint}')
    return PROFILES[name]
