"""Read a bag into a pandas data frame, and write its peaks to a CSV file.

    .venv/bin/wheelset-track-sim run damage_wheel_1 --duration 1 --out run.mcap
    .venv/bin/python examples/bag_to_pandas.py run.mcap

This writes peaks.csv. It needs the extra `analysis` (`python3 tools/setup_env.py analysis`).
"""

import sys

import wheelset_track_sim as wts

frame = wts.read_bag(sys.argv[1]).to_pandas()  # a row a step; SI units are in frame.attrs["units"]
peaks = frame.max(numeric_only=True).rename("peak").to_frame()
peaks["unit"] = [frame.attrs["units"].get(name, "") for name in peaks.index]
peaks.to_csv("peaks.csv")
print(f"{len(frame)} steps, largest force of wheel 1 {frame['wheel_1'].max() / 1e3:.1f} kN")
