"""The type of arrays: of floats, of double precision."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
