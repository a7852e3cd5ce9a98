"""An explorer on the toy models, and messages of the server as a page reads them."""

import dataclasses
import json
import struct

import numpy as np

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.explore.answers import Explorer
from wheelset_track_sim.explore.view import Base


class ToyExplorer(Explorer):
    """Answers on the toy models, whatever the view names."""

    def models(self, scenario, progress=lambda stage, share: None):
        progress("toy models", 0.5)
        tolerance = scenario.contact.largest_estimate
        made = self._models.get("toy") or dataclasses.replace(
            toy_models(), tables="smooth", tolerance=tolerance, _smooth=None, _preloads={}
        )
        self._models["toy"] = made
        return made


def toy_explorer(*changes: str, like: str = "undamaged") -> ToyExplorer:
    return ToyExplorer(Base.of(toy_scenario(*changes, like=like)))


def unpacked(message: bytes) -> dict:
    """Header of a message with its arrays."""
    (length,) = struct.unpack_from("<I", message)
    header = json.loads(message[4 : 4 + length])
    at = 4 + length
    for name, size in header["arrays"].items():
        header["arrays"][name] = np.frombuffer(message, np.float32, size, at)
        at += 4 * size
    assert at == len(message)
    return header
