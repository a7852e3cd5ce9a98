"""Simulate one turn of a damaged wheel, and draw the contact forces.

    .venv/bin/python examples/run_and_plot.py

This writes forces.png.
"""

import numpy as np
from matplotlib import pyplot as plt

import wheelset_track_sim as wts

simulator = wts.Simulator(wts.load_scenario("damage_wheel_1", ["irregularities.0.h=0.001"]))
turn = simulator.advance(2713)
position = 1e-3 * np.arange(len(turn))  # m

figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.plot(position, turn.forces / 1e3, label=["wheel 1", "wheel 2"])
axes.set(xlabel="position along the track (m)", ylabel="contact force (kN)")
axes.legend()
figure.savefig("forces.png", dpi=150)
print(f"largest force {turn.forces.max() / 1e3:.1f} kN")
