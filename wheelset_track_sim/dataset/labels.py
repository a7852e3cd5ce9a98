"""Labels: everything that makes a sample, drawn from the seed and the number of its train, passage and wheelset."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..scenario import WHEELS
from .damage import SIZES
from .drawn import value_of
from .spec import DatasetSpec

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
STRIDE = (300, 900)
"""Steps between the beginnings of two samples of a passage, at least and below."""
CLEAR = 0.2
"""Track from the beginning of a sample to where its damage meets the rail, at least, and its half length beside, m."""
LINE_BAYS = 24
"""Bays after which heights of the rails repeat."""
SPLITS = ("train", "validation", "test")


@dataclass(frozen=True)
class Label:
    """What makes a sample, SI units. NaN where something does not apply."""

    sample: int
    wheelset: int
    train: int
    passage: int
    """Of the train, from 0."""
    split: str
    """``train``, ``validation`` or ``test``; the same for all samples of a train."""
    damage: str
    damaged_wheel: str
    """``wheel_1``, ``wheel_2``, or empty without damage."""
    length: float
    worn_length: float
    a: float
    b: float
    h: float
    y: float
    angle: float
    speed: float
    axle_load: float
    wheel_roughness: float
    """dB above the limit of ISO 3095."""
    rail_roughness: float
    wheel_seed: int
    rail_seed: int
    pad_scatter: float
    ballast_scatter: float
    track_seed: int
    joint_position: float
    joint_dip_angle: float
    start_step: int
    """Step of the passage at which the damage comes in."""
    noise_seed: int

    @property
    def sizes(self) -> dict[str, float]:
        """Sizes of the damage, m."""
        return {name: getattr(self, name) for name in SIZES}


COLUMNS = tuple(field.name for field in dataclasses.fields(Label))


def labels(spec: DatasetSpec, seed: int, samples: int) -> Iterator[Label]:
    """Labels of a data set in their order; those of a smaller one are the first of a larger one."""
    for first in range(0, samples, spec.wheelsets):
        yield from group(spec, seed, first // spec.wheelsets, samples)


def group(spec: DatasetSpec, seed: int, number: int, samples: int) -> list[Label]:
    """Labels of one passage of one train, of a data set of so many ``samples``."""
    train, passage = divmod(number, spec.passages)
    of_train = np.random.default_rng([seed, 1, train])
    wheel_roughness, wheel_seed = value_of(spec.wheel_roughness, of_train.random()), _seed(of_train)
    here = np.random.default_rng([seed, 2, train, passage])
    drawn = {
        name: value_of(getattr(spec, name), here.random())
        for name in ("speed", "axle_load", "rail_roughness", "pad_scatter", "ballast_scatter")
    }
    spacing, dx, turn = spec.base.track.spacing, spec.base.step_length, spec.base.steps_per_revolution
    jointed, joint = here.random() < spec.joint.share, LINE_BAYS * spacing * (0.1 + 0.8 * here.random())
    dip = value_of(spec.joint.dip_angle, here.random())
    common: dict[str, Any] = drawn | {
        "train": train,
        "passage": passage,
        "split": _split(spec, seed, train),
        "wheel_roughness": wheel_roughness,
        "wheel_seed": wheel_seed,
        "rail_seed": _seed(here),
        "track_seed": _seed(here),
        "joint_position": joint if jointed else math.nan,
        "joint_dip_angle": dip if jointed else math.nan,
    }
    starts = np.cumsum(here.integers(*STRIDE, spec.wheelsets)).tolist()
    found = []
    first = number * spec.wheelsets
    for place, start in enumerate(starts[: samples - first]):
        wheelset = train * spec.wheelsets + place
        kind, wheel, sizes = _damage(spec, np.random.default_rng([seed, 3, wheelset]))
        clear = math.ceil((CLEAR + max(each.half_length for each in spec.damage)) / dx)
        meets = start + int(here.integers(clear, turn - clear))  # where it is first in the middle of the contact
        row: dict[str, Any] = dict.fromkeys(SIZES, math.nan) | sizes | common
        found.append(
            Label(
                sample=first + place,
                wheelset=wheelset,
                damage=kind,
                damaged_wheel=wheel,
                angle=2 * math.pi * ((meets - spec.base.tread_origin) % turn) / turn if wheel else math.nan,
                start_step=start,
                noise_seed=_seed(here),
                **row,
            )
        )
    return found


def _damage(spec: DatasetSpec, random: np.random.Generator) -> tuple[str, str, dict[str, float]]:
    """Kind, wheel and sizes of the damage of a wheelset."""
    weights = np.cumsum([kind.weight for kind in spec.damage])
    kind = spec.damage[int(np.searchsorted(weights, random.random() * weights[-1], side="right"))]
    wheel = WHEELS[int(random.integers(2))]
    sizes = kind.sizes(random.random(4).tolist())
    return kind.type, wheel if sizes else "", sizes


def _split(spec: DatasetSpec, seed: int, train: int) -> str:
    """Part of a train: spread evenly, so that few trains are split about as many."""
    share = (np.random.default_rng([seed, 0]).random() + GOLDEN * train) % 1.0
    ends = np.cumsum([spec.split.train, spec.split.validation])
    return SPLITS[int(np.searchsorted(ends, share, side="right"))]


def _seed(random: np.random.Generator) -> int:
    return int(random.integers(2**31 - 1))
