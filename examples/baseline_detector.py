"""Train a plain detector on a data set, and draw how well it finds damaged wheels.

    .venv/bin/python examples/baseline_detector.py damage.zarr [PICTURE]

The detector is a random forest on a few numbers of the axle box accelerations: peaks, kurtosis and levels of bands. It
is trained on the part `train` and tested on the wheelsets of the part `test`. A threshold on the peak alone stands
beside it. It needs the extra `analysis` and scikit-learn (`.venv/bin/python -m pip install scikit-learn`).
"""

import json
import sys
from pathlib import Path

import numpy as np
import xarray
from matplotlib.figure import Figure
from pyarrow import parquet
from sklearn.ensemble import RandomForestClassifier
from sklearn.metrics import roc_auc_score, roc_curve

BANDS = ((20, 60), (60, 150), (150, 400), (400, 1000), (1000, 2500), (2500, 5000))  # Hz
DAMAGED = "axle_box_acceleration"


def features(signals: np.ndarray, rate: float) -> np.ndarray:
    """Numbers (samples, 2 (3 + bands)) of signals (samples, 2, values), both boxes, those of the noisier one first."""
    spread = signals.std(axis=2)
    peak = np.abs(signals).max(axis=2)
    kurtosis = ((signals - signals.mean(axis=2, keepdims=True)) ** 4).mean(axis=2) / spread**4
    power = np.abs(np.fft.rfft(signals, axis=2)) ** 2
    frequency = np.fft.rfftfreq(signals.shape[2], 1 / rate)
    levels = [power[:, :, (frequency >= low) & (frequency < high)].sum(axis=2) for low, high in BANDS]
    found = np.log(np.stack([spread, peak, kurtosis, *levels], axis=2))  # (samples, 2, numbers)
    order = peak.argsort(axis=1)[:, ::-1, np.newaxis]
    return np.take_along_axis(found, order, axis=1).reshape(len(signals), -1)


def main(folder: str, picture: str = "roc.png") -> dict[str, float]:
    """Train and test; returns the areas under the curves."""
    data = xarray.open_zarr(folder)
    labels = parquet.read_table(Path(folder) / "labels.parquet").to_pandas()
    signals = data[DAMAGED].values.astype(float)
    rate = data[DAMAGED].attrs["rate_Hz"]
    damaged = (labels["damage"] != "none").to_numpy()
    known = np.isfinite(signals).all(axis=(1, 2))
    training, testing = (known & (labels["split"] == part).to_numpy() for part in ("train", "test"))
    x = np.column_stack([features(signals, rate), labels[["speed", "axle_load"]]])
    forest = RandomForestClassifier(400, min_samples_leaf=2, random_state=0, n_jobs=1).fit(
        x[training], damaged[training]
    )
    scores = {
        "random forest": forest.predict_proba(x[testing])[:, 1],
        "threshold on the peak": np.abs(signals[testing]).max(axis=(1, 2)),
    }
    card = json.loads((Path(folder) / "card.json").read_text(encoding="utf-8"))
    figure = Figure(figsize=(5.2, 4.8), dpi=125, layout="constrained")
    axes = figure.subplots()
    areas = {}
    for (name, score), colour in zip(scores.items(), ("#d55e00", "#0072b2"), strict=True):
        areas[name] = float(roc_auc_score(damaged[testing], score))
        wrong, right, _ = roc_curve(damaged[testing], score)
        axes.plot(wrong, right, color=colour, label=f"{name}, area {areas[name]:.2f}")
        print(f"{name}: area {areas[name]:.3f} over {testing.sum()} samples of the part test")
    axes.plot([0, 1], [0, 1], color="#888888", linewidth=0.8, linestyle="--", label="chance")
    axes.set_xlabel("false alarms")
    axes.set_ylabel("damaged wheelsets found")
    axes.set_title(f"{card['title']}\n{training.sum()} samples for training, {testing.sum()} for tests", fontsize=10)
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(picture)
    return areas


if __name__ == "__main__":
    main(*sys.argv[1:])
