"""Where joints, loads and springs take hold of the links: points of bodies, and the nodal dofs that move them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    pass

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter turn
