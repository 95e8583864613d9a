#!/usr/bin/env python3
"""Makes pancake.glb and picture.png beside this file: python3 samples/pancake/make.py

Millimetres, the eye is the origin and looks along -z, y is up. From the eye: a reflective polariser, a quarter-wave plate, a
curved half mirror, a circular polariser, the display. Light goes through the half mirror, back from the reflective polariser,
back from the half mirror, and out through the reflective polariser.
"""

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from solids import Frame, conic, digits, lens, rectangle, write_glb, write_png

REFLECTIVE, PLATE, VERTEX, CIRCULAR, DISPLAY = -18.0, -18.5, -30.0, -43.5, -44.0
RADIUS, SHELL = 80.0, 1.5

at = lambda z: Frame([0.0, 0.0, z])
parts = [
    ("REFLECTIVE_POLARISER", at(REFLECTIVE), [rectangle(16.0, 16.0)]),
    ("QUARTER_WAVE_PLATE", at(PLATE), [rectangle(16.0, 16.0)]),
    # Hollow towards the eye; its outside is concentric and has no power to speak of.
    ("HALF_MIRROR", at(VERTEX), lens(conic(RADIUS + SHELL, 0.0, -SHELL), conic(RADIUS), 16.0)),
    ("CIRCULAR_POLARISER", at(CIRCULAR), [rectangle(16.0, 16.0)]),
    ("DISPLAY", at(DISPLAY), [rectangle(8.0, 4.5)]),
]
write_glb(HERE / "pancake.glb", parts, "samples/pancake/make.py")

number = digits("88", -0.14, -0.1, 0.2, 0.04)


def picture(u, v):
    """A test card: lines every tenth of the width, a disc with a number cut out of it, a frame."""
    frame = abs(u) > 0.98 or abs(v) > 9 / 16 - 0.02
    line = min(abs(u * 5 - round(u * 5)), abs(v * 5 - round(v * 5))) < 0.03
    disc = math.hypot(u, v) < 0.3
    return float(frame or (disc and not number(u, v)) or (not disc and line))


write_png(HERE / "picture.png", 640, 360, picture)
