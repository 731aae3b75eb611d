"""Frame letters and array aliases: the one list.

Frames, in Drake's monogram notation (``X_WC``, ``p_NQ``, ``R_WS``):

===  ==========================================================
W    world, z up
B    arm base
E    nozzle: origin at its tip, z along the jet
C    camera, z forward, x right, y down in the image
P    patient: in the back's plane, x to the person's right,
     y to the head, z out of the body
M    person mesh as stored (metres, z up, the back faces +y)
S    surface at the washed point, z outward along the normal
I    image, pixels
N    canonical space, dimensionless
Q    current point
G    goal
===  ==========================================================

``T_IN`` (canonical to image) is a T, not an X: that map is anisotropic.
Inside ``bath_drake.field`` the paper's letters hold (q, q_d, gamma, beta,
kappa, phi, theta) and q is a canonical point; elsewhere q is joint positions
and the canonical point is ``p_NQ``.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
ByteArray = NDArray[np.uint8]
IntArray = NDArray[np.int64]
