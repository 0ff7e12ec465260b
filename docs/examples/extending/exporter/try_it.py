"""Every plan folder now holds the new file, and what is read back from it is what was planned."""

import tempfile
from pathlib import Path

import numpy as np

import nospill as ns
from nospill.export import EXPORTERS

plan = ns.plan(ns.load("pp-two-cups"))
with tempfile.TemporaryDirectory() as folder:
    plan.save(folder)
    written = Path(folder) / "joints.deg.csv"
    print(written.read_text().splitlines()[0])
    samples = EXPORTERS["timed-degrees"].read(written, plan.scene)
assert np.allclose(samples.t, plan.trajectory.t, atol=1e-9)
assert np.allclose(samples.position, plan.trajectory.joint_position, atol=1e-9)
print(f"{len(samples.t)} samples, the same as planned")
