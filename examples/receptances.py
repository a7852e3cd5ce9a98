"""Compute receptances and Green's functions of wheelset and track as arrays.

    .venv/bin/python examples/receptances.py

The receptances H[f, i, j] and Green's functions G[i, j, t] relate contact i to a force at contact j.
"""

import numpy as np

import wheelset_track_sim as wts

wheelset, track = wts.load_wheelset("x40"), wts.load_track("ballasted_60e1")

frequencies = np.linspace(0.0, 2000.0, 401)  # Hz
of_rail = wts.receptance(track, frequencies, load_at=0.3)[:, 0, 0]  # m/N, in the middle of a bay
of_wheel = wts.receptance(wheelset, frequencies)[:, 0, 0]
high = frequencies > 900.0
pinned = frequencies[high][np.abs(of_rail[high]).argmax()]

times, green = wts.green_function(track, duration=0.1, dt=3.6e-5)  # s, m/(N s)
moving = wts.moving_green_functions(track, speed=27.8, dx=1e-3, bays=10, starts=4)

print(f"static receptance: rail {of_rail[0].real:.3e} m/N, wheel {of_wheel[0].real:.3e} m/N")
print(f"pinned-pinned resonance of the rail: {pinned:.0f} Hz")
print(f"Green's functions: {green.shape} at {len(times)} times; moving: {moving.direct.shape}")
