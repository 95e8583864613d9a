#!/usr/bin/env python3
"""Makes windshield.glb and slide.png beside this file: python3 samples/windshield/make.py

Backlit LCD, fold mirror, freeform mirror, curved windshield, in the order in which light meets them; each part in its own
axes, z towards the light. Millimetres, the driver's eye is the origin and looks along -z, y is up. What the parts are, and
the exact surfaces, are said in windshield.optics.toml.
"""

import math
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from solids import Frame, add, box, digits, height_field, mirrored, rectangle, sheet, turned, unit, write_glb, write_png


def turn(v, degrees):
    """About x."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]]


def back(v):
    return [-x for x in v]


# The chief ray from the eye to the display: 4 degrees down, then reflected at 60, 18 and 30 degrees of incidence.
GAZE = turn([0.0, 0.0, -1.0], -4.0)
at_windshield = add([0.0, 0.0, 0.0], GAZE, 800.0)
windshield = Frame(at_windshield, turn(back(GAZE), 60.0))
down = mirrored(GAZE, windshield.z)
freeform = Frame(add(at_windshield, down, 300.0), turn(back(down), 18.0))
forward = mirrored(down, freeform.z)
fold = Frame(add(freeform.origin, forward, 130.0), turn(back(forward), -30.0))
last = mirrored(forward, fold.z)
# The display's tilt and defocus are part of the design, as the mirror's polynomial is.
TILT, DEFOCUS = -0.09694793059257051, -3.641794624248708
straight = Frame(add(fold.origin, last, 70.0 + DEFOCUS), back(last))
display = Frame(straight.origin, add(straight.z, straight.y, math.tan(TILT)))


def toroid(across, along):
    """Sag of a circle of radius `across` in x, turned about a line along x at a distance `along`."""

    def sag(x, y):
        reach = along - (across - math.sqrt(across**2 - x**2))
        return along - math.sqrt(reach**2 - y**2)

    return sag


def polynomial(radius, coefficients):
    """A sphere and the terms 1, x, y, x², xy, y², … of the sidecar."""

    def sag(x, y):
        height, index, order = (x * x + y * y) / radius / (1 + math.sqrt(1 - (x * x + y * y) / radius**2)), 0, 0
        while index < len(coefficients):
            for j in range(order + 1):
                height += coefficients[index] * x ** (order - j) * y**j
                index += 1
            order += 1
        return height

    return sag


sidecar = tomllib.loads((HERE / "windshield.optics.toml").read_text())
mirror = next(bind["shape"] for bind in sidecar["bind"] if bind["path"] == "MIRROR_FREEFORM")
inner = height_field(toroid(2500.0, 5000.0), 150.0, 120.0, 20, 16)
outer = height_field(lambda x, y: toroid(2504.5, 5004.5)(x, y) - 4.5, 150.0, 120.0, 20, 16)
parts = [
    ("WINDSHIELD", windshield, sheet(outer, inner)),
    ("MIRROR_FREEFORM", freeform, [height_field(polynomial(mirror["radius"], mirror["coeffs"]), 120.0, 50.0, 24, 10)]),
    ("FOLD_MIRROR", fold, box(65.0, 32.0, -3.0, 0.0)),
    ("LCD_ACTIVE_AREA", display, [rectangle(30.0, 10.0)]),
    ("LCD_BEZEL", display, [rectangle(50.0, 30.0, -8.0)]),
    ("BACKLIGHT", display, box(31.0, 11.0, -6.0, -0.5)),
]
write_glb(HERE / "windshield.glb", parts, "samples/windshield/make.py")

speed = digits("50", -0.16, -0.14, 0.28, 0.05)
limit = digits("60", 0.575, -0.06, 0.12, 0.016)


def picture(u, v):
    """A speed, a turn to the left, a limit, and a frame: white on black."""
    frame = abs(u) > 0.985 or abs(v) > 1 / 3 - 0.015
    arrow = abs(u + 0.6) < 0.02 and -0.2 < v < 0.1 or abs(v - 0.1) < 0.02 and -0.7 < u < -0.58
    head = -0.8 < u < -0.7 and abs(v - 0.1) < 0.6 * (u + 0.8)
    ring = 0.17 < math.hypot(u - 0.64, v) < 0.2
    return float(frame or arrow or head or ring or speed(u, v) or limit(u, v))


write_png(HERE / "slide.png", 600, 200, picture)
