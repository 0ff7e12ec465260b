"""The four solids of matrix-rigid with and without the new limit: it is met, judged, and costs time."""

import nospill as ns

scene = ns.load("matrix-rigid")
gentle = ns.plan(scene)
assert gentle.certificate.ok
worst = max(row.worst_value for row in gentle.certificate.rows if row.constraint == "sideways")
assert 2.9 < worst <= 3.0

hasty = ns.plan(scene, ignore=["sideways"])
assert not hasty.certificate.ok  # the judge leaves out nothing
assert {row.constraint for row in hasty.certificate.rows if not row.ok} == {"sideways"}
assert hasty.duration < gentle.duration
print(f"{gentle.duration:.3f} s with at most {worst:.2f} m/s^2 sideways, {hasty.duration:.3f} s without the limit")
