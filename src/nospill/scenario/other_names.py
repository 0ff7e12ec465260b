"""Other names that people give to keys of a scenario, and what to write instead."""

from __future__ import annotations

from collections.abc import Collection

_HERE: dict[str, tuple[str, str]] = {
    "com_height": ("centre_of_mass_height", ""),
    "cog_height": ("centre_of_mass_height", ""),
    "center_of_mass_height": ("centre_of_mass_height", ""),
    "com": ("centre_of_mass", ""),
    "cog": ("centre_of_mass", ""),
    "diameter": ("radius", "a diameter: give radius = half of it"),
    "position": ("at", ""),
    "place": ("at", ""),
    "fill": ("liquid_height", ""),
    "fill_height": ("liquid_height", ""),
    "fill_level": ("liquid_height", ""),
    "level": ("liquid_height", ""),
    "slosh_limit": ("max_slosh_height", ""),
    "max_height": ("max_slosh_height", ""),
    "rim_margin": ("freeboard_reserve", "it is a fraction of the way from the liquid at rest to the rim"),
    "depth": ("width", "sides are length and width, the third is height"),
    "weight": ("mass", ""),
    "payload": ("mass", ""),
    "mu": ("friction", ""),
    "friction_coefficient": ("friction", ""),
    "rotation": ("yaw", ""),
    "orientation": ("yaw", ""),
    "angle": ("yaw", ""),
    "viscosity": ("kinematic_viscosity", "it is the dynamic one over the density"),
    "name": ("model", ""),
    "type": ("model", ""),
    "frame": ("tip", ""),
    "flange": ("tip", ""),
    "sample_rate": ("rate", ""),
    "frequency": ("rate", ""),
    "from": ("start", ""),
    "to": ("end", ""),
    "max_speed": ("speed", ""),
    "max_velocity": ("speed", ""),
    "velocity": ("speed", ""),
    "max_acceleration": ("acceleration", ""),
    "max_jerk": ("jerk", ""),
    "max_torque": ("torque", ""),
}
"""Other name -> the key, and a remark where it is not the same quantity. Said where the key is allowed."""

_ELSEWHERE = {
    "max_speed": "write speed under [robot.limits], or max_speed of the tray under [motion]",
    "max_velocity": "write speed under [robot.limits], or max_speed of the tray under [motion]",
    "max_acceleration": "write acceleration under [robot.limits], or max_acceleration of the tray under [motion]",
    "max_jerk": "write jerk under [robot.limits]",
    "max_torque": "write torque under [robot.limits]",
    "sample_rate": "write rate under [output]",
    "time_limit": "write max_duration under [motion]",
    "gravity": "gravity is 9.80665 m/s^2 always",
    "collision": "write what is in the way as [[obstacle]]",
    "collisions": "write what is in the way as [[obstacle]]",
    "obstacles": "write [[obstacle]], one for each",
}
"""Other name -> what to do, said where no key of that table is meant."""


def meant(key: str, allowed: Collection[str]) -> str | None:
    """What is probably meant by an unknown key, as the end of a sentence; None where nothing is known.

    Args:
        key: as written.
        allowed: keys of the table it stands in.
    """
    plain = key.casefold().replace("-", "_")
    known, remark = _HERE.get(plain, ("", ""))
    if known in allowed:
        return remark if known in remark else f"the key is {known}" + (f"; {remark}" if remark else "")
    return _ELSEWHERE.get(plain)
