"""Second opinions on a plan: free bodies in MuJoCo, and parameters drawn at random."""

import nospill as ns
from nospill.margins import Ranges, margins
from nospill.verify import verify

plan = ns.plan("pp-two-cups")
print(f"MuJoCo: {verify(plan).message}")

drawn = margins(plan, ranges=Ranges(friction=0.05, fill=1e-3), samples=200)
for what, chance in {
    "spill": drawn.spill,
    "slide": drawn.slide,
    "tip": drawn.tip,
    "break a limit": drawn.any_limit,
}.items():
    print(
        f"{what}: {100 * chance.value:.0f} % of the draws (95 %: {100 * chance.low:.1f} to {100 * chance.high:.1f} %)"
    )
for risk in drawn.constraints:
    print(f"  {risk.constraint} of {risk.subject}: at most {100 * risk.largest_use:.1f} % of its limit")
