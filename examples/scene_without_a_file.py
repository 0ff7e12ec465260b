"""A scene without a file: the tables of a scenario as classes that an editor completes."""

import nospill as ns

scenario = ns.Scenario(
    robot=ns.Robot(model="ur10e"),
    tray=ns.Tray(size=["335 mm", "250 mm"], friction=0.466, friction_reserve=0.1, offset="108 mm", mass="0.4 kg"),
    cargo=[
        ns.Cylinder(
            name="tea",
            at=["-80 mm", "0 mm"],
            radius="35 mm",
            height="99 mm",
            liquid="water",
            liquid_height="49 mm",
            max_slosh_height="12 mm",
            empty_mass="0.1 kg",
        ),
        ns.Box(name="parcel", at=["80 mm", "0 mm"], length="80 mm", width="60 mm", height="90 mm", mass="0.3 kg"),
    ],
    path=ns.LinePath(start=["0.6 m", "-0.4 m", "0.5 m"], end=["0.6 m", "0.4 m", "0.5 m"], yaw=["0 deg", "90 deg"]),
    motion=ns.Motion(end="residual"),
)

scene = ns.load(scenario)
scene.save("tea-and-parcel.toml")  # a file like any other, for the command line or a colleague

plan = ns.plan(scene)
print(plan.message)
plan.plot("tray").savefig("scene_without_a_file.png", dpi=100)
