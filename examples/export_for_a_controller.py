"""Files for controllers, each read back and judged as its receiver plays it."""

import nospill as ns

plan = ns.plan("pp-two-cups")
for name, file, rate in (
    ("joint-trajectory", "two-cups.yaml", 100.0),
    ("joint-trajectory", "two-cups-coarse.yaml", 20.0),
    ("tray-csv", "two-cups.csv", 500.0),
):
    done = ns.hand_over(plan, name, file, rate=rate)
    # points that are far apart are joined by the receiver's own curve, which is what is judged
    worst = done.certificate.worst
    print(f"{file}: {done.samples} samples at {done.rate:g} Hz for {done.exporter.receiver}")
    print(f"  {done.certificate.word}: {worst.constraint} of {worst.subject} {100 * worst.use:.1f} % of its limit")
