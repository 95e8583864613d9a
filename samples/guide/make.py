#!/usr/bin/env python3
"""Makes guide.glb and picture.png beside this file: python3 samples/guide/make.py

Millimetres, the eye is the origin and looks along -z, y is up. A collimated display behind the left end of a slab of glass shines
into it onto a mirror that lies at 30 degrees in the slab, which sends the light along it, 60 degrees off the normal: it is totally
reflected. Three half-transparent mirrors parallel to the first one send it out to the eye, in the direction in which it came in.
The slab is cut along the mirrors into prisms, as such guides are made.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from solids import Frame, collimator, prism, sign, write_glb, write_png

FRONT, BACK, HALF_WIDTH = -18.0, -21.0, 12.0
# How far a mirror reaches along the slab. Light that comes in straight is back at the same height, on its way to the back, after
# twice that: so far apart are the mirrors, and each sees the middle of the first one. They are named by where they meet the back.
REACH = (FRONT - BACK) / math.tan(math.radians(30.0))
MIRRORS = [-6.5 * REACH, -2.5 * REACH, -0.5 * REACH, 1.5 * REACH]
END = 4 * REACH

parts = []
for i, left in enumerate(MIRRORS):
    right = MIRRORS[i + 1] if i < 3 else END
    slope = REACH if i < 3 else 0.0
    outline = [(left, BACK), (right, BACK), (right + slope, FRONT), (left + REACH, FRONT)]
    # Faces: 0 back, 1 the mirror at its right, 2 front, 3 the mirror at its left, then the ends.
    parts.append((f"PRISM_{i}", Frame(), prism(outline, HALF_WIDTH)))
parts += collimator(MIRRORS[0] + REACH / 2, BACK - 2.0, 30.0, 1.5, (3.0, 1.7))
write_glb(HERE / "guide.glb", parts, "samples/guide/make.py")
write_png(HERE / "picture.png", 600, 340, sign("123"))
