"""Read a part of a bag into xarray, and write a bag of any length to Parquet, one block in memory.

    .venv/bin/wheelset-track-sim run damage_wheel_1 --duration 1 --out run.mcap
    .venv/bin/python examples/bag_to_xarray.py run.mcap

This writes run.parquet. It needs the extra `analysis` (`python3 tools/setup_env.py analysis`).
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import wheelset_track_sim as wts
from wheelset_track_sim.bags import blocks

bag = Path(sys.argv[1])
data = wts.read_bag(bag, stop=0.1).to_xarray()  # dimensions time, wheel, node, component
highest = float(data.stress.sel(node="A1", component="yy").max()) / 1e6  # MPa
print(f"along the axle at A1: {highest:.1f} MPa in the first 0.1 s")

schema = pa.schema([("step", pa.int64()), ("wheel_1", pa.float64()), ("wheel_2", pa.float64())])
rows = 0
with pq.ParquetWriter(bag.stem + ".parquet", schema) as table:
    for block in blocks(bag):
        step = block.first_step + np.arange(len(block), dtype=np.int64)
        table.write(pa.table([step, block.forces[:, 0], block.forces[:, 1]], schema))
        rows += len(block)
print(f"{rows} steps of forces, in N")
