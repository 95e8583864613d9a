#!/usr/bin/env python3
"""Makes waveguide.glb and picture.png beside this file: python3 samples/waveguide/make.py

Millimetres, the eye is the origin and looks along -z, y is up. A collimated display behind the left end of a slab of glass shines
onto a grating on its back, whose first order runs along the slab, totally reflected. A grating of the same period on its front lets
a share of it out to the eye wherever it comes by, in the direction in which it came in.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from solids import Frame, collimator, prism, sign, write_glb, write_png

FRONT, BACK, HALF_WIDTH = -18.0, -19.5, 10.0
INDEX, PERIOD_NM, WAVELENGTH_NM = 1.7, 400.0, 550.0
# From one reflection at the front to the next, for light that came in straight.
STEP = 2 * (FRONT - BACK) * math.tan(math.asin(WAVELENGTH_NM / PERIOD_NM / INDEX))
# The eye is under the second of three places where such light meets the second grating, and the fifth where it meets the front.
IN = -4.5 * STEP
half_in, half_out = 2.0, 1.5 * STEP
left, right = IN - 5.0, half_out + 6.0
outline = [
    (left, BACK), (IN - half_in, BACK), (IN + half_in, BACK), (right, BACK),
    (right, FRONT), (half_out, FRONT), (-half_out, FRONT), (left, FRONT),
]  # fmt: skip
# Faces: 0 back, 1 grating in, 2 back, 3 right end, 4 front, 5 grating out, 6 front, 7 left end, then the sides.
parts = [("SLAB", Frame(), prism(outline, HALF_WIDTH))]
parts += collimator(IN, BACK - 2.0, 30.0, 1.5, (3.0, 1.7))
write_glb(HERE / "waveguide.glb", parts, "samples/waveguide/make.py")
write_png(HERE / "picture.png", 600, 340, sign("400"))
