"""Force signals of the toy wheelset, and models on which they are identified."""

import dataclasses

import numpy as np

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.identification.forward import TrackModels
from wheelset_track_sim.identification.observation import Observation
from wheelset_track_sim.simulation.passages import Passages

MODELS = dataclasses.replace(toy_models(), tables="smooth", _smooth=None, _preloads={})
SCENARIO = toy_scenario()


class ToyTracks(TrackModels):
    """The toy models; properties of the track are known."""

    def __init__(self):
        super().__init__(SCENARIO, 0.0)

    def models(self, number, sensors):
        """The toy models."""
        return MODELS


def passed(damage, place=0.0, *, speed=25.0, noise=1e3, gain=1.0, reported=1.0, seed=1):
    """Observation of a damage that meets the rail at ``place`` of a bay, m; ``reported`` is the share of the speed."""
    passages = Passages(SCENARIO, models=MODELS, before=0.8, after=2.4)
    turned = dataclasses.replace(damage, angle=place / SCENARIO.wheelset.rolling_radius)
    block = passages.run([turned], speed=speed)
    force = gain * block.forces[::3, 0] + noise * np.random.default_rng(seed).standard_normal(len(block.forces[::3]))
    time = 3 * block.step_period * np.arange(len(force))
    return Observation("force", time, force, speed=speed * reported, noise=noise)
