"""Names of array types; shapes and units are said where an array is."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Single: TypeAlias = NDArray[np.float32]
Complex: TypeAlias = NDArray[np.complex128]
