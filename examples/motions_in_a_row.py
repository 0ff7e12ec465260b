"""Two motions in a row: the second begins while the liquids still swing from the first."""

import nospill as ns

there = ns.load("matrix-liquid-soft-end").changed(
    {"path": ns.LinePath(start=["0.75 m", "-0.4 m", "1.1 m"], end=["0.75 m", "0.2 m", "1.1 m"])}
)
first = ns.plan(there)

onwards = {"path": ns.LinePath(start=["0.75 m", "0.2 m", "1.1 m"], end=["0.75 m", "0.4 m", "1.3 m"])}
calm = ns.plan(there.changed(onwards))
wait = 0.1  # s between the two motions
second = ns.plan(ns.with_residual_slosh(there.changed(onwards), first, wait))

for what, plan in {"first": first, "second, liquids at rest": calm, f"second, {wait:g} s later": second}.items():
    print(f"{what}: {plan.duration:.3f} s, {plan.status}")
second.plot("slosh-heights").savefig("motions_in_a_row.png", dpi=100)
