#!/usr/bin/env python3
"""Makes birdbath.glb and picture.png beside this file: python3 samples/birdbath/make.py

Millimetres, the eye is the origin and looks along -z, y is up. A display above the line of sight shines down onto a beam
splitter at 45 degrees, which mirrors its light forwards to a spherical half mirror; from there it comes back through the beam
splitter to the eye. The display is 0.75 mm inside the focus of the half mirror: its picture stands two metres away.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from solids import Frame, box, conic, digits, lens, rectangle, write_glb, write_png

SPLITTER, VERTEX, DISPLAY = -25.0, -45.0, 18.0
RADIUS, SHELL = 77.5, 1.5

# The half mirror's axis looks at the eye; its outside is concentric with its inside, so that what is outside is seen as it is.
half_mirror = lens(conic(RADIUS + SHELL, 0.0, -SHELL), conic(RADIUS), 12.0)
parts = [
    ("DISPLAY", Frame([0.0, DISPLAY, SPLITTER], [0.0, -1.0, 0.0]), [rectangle(4.0, 2.25)]),
    # Its +z looks at the display and at the half mirror.
    ("BEAM_SPLITTER", Frame([0.0, 0.0, SPLITTER], [0.0, 1.0, -1.0]), box(13.0, 15.0, -1.0, 0.0)),
    ("HALF_MIRROR", Frame([0.0, 0.0, VERTEX]), half_mirror),
    # Below the beam splitter, which mirrors it to the eye, and about the eye.
    ("SHADE", Frame([0.0, -14.0, -22.0], [0.0, 1.0, 0.0]), [rectangle(30.0, 30.0)]),
    ("FACE", Frame([0.0, 0.0, 4.0], [0.0, 0.0, -1.0]), [rectangle(60.0, 60.0)]),
]
write_glb(HERE / "birdbath.glb", parts, "samples/birdbath/make.py")

clock = digits("1024", -0.36, -0.11, 0.22, 0.045)


def picture(u, v):
    """The time, a dial and three bars of the primaries' colours on black, in a frame."""
    white, red, green, blue = (1.0, 1.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if abs(u) > 0.98 or abs(v) > 9 / 16 - 0.02 or clock(u, v):
        return white
    if -0.36 < v < -0.24 and abs(u) < 0.6:
        return (red, green, blue)[min(2, int((u + 0.6) / 0.4))]
    if 0.1 < math.hypot(u - 0.7, v - 0.28) < 0.14:
        return (1.0, 0.5, 0.0)
    return (0.0, 0.0, 0.0)


write_png(HERE / "picture.png", 640, 360, picture)
