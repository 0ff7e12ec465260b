"""Change one cup: what a cup half as full costs, and what a cup less saves."""

import nospill as ns

scene = ns.load("matrix-liquid")
variants = {
    "as bundled": scene,
    "c1 half as full": scene.changed({"cargo.c1.liquid_height": "25 mm", "cargo.c1.mass": "0.11 kg"}),
    "without c4": scene.changed({"cargo.c4": None}),
}

for what, variant in variants.items():
    plan = ns.plan(variant)
    print(f"{what}: {plan.duration:.3f} s, {plan.status}; {plan.limiting_text}")
    if what == "c1 half as full":
        plan.plot("slosh-heights").savefig("change_one_cup.png", dpi=100)

variants["c1 half as full"].save("half-full.toml")  # a scenario file like any other
