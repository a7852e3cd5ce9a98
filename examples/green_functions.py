"""Get Green's functions as arrays, convolve a blow with them, and save them.

    .venv/bin/python examples/green_functions.py

This writes green_functions.npz. A blow of 100 kN and 1 ms strikes the rail above a sleeper, and half a bay further.
"""

import numpy as np

import wheelset_track_sim as wts

dt = 3.6e-5  # s
track = wts.load_track("ballasted_60e1")
blow = 100e3 * np.sin(np.pi * np.arange(0.0, 1e-3, dt) / 1e-3)  # N

arrays = {}
for name, place in (("above a sleeper", 0.0), ("mid-bay", 0.3)):  # m
    times, green = wts.green_function(track, duration=0.05, dt=dt, load_at=place)  # green[i, j, t], m/(N s)
    deflection = dt * np.convolve(blow, green[0, 0])[: len(times)]  # m, rail 1 under a force on rail 1
    arrays[name] = green
    print(f"{name}: {1e3 * deflection.max():.2f} mm after {1e3 * times[deflection.argmax()]:.1f} ms")

np.savez_compressed("green_functions.npz", times=times, **arrays)
