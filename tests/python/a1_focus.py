"""Luminance of the caustic of the peers' scene A1 about its focus, by light tracing: the oracle of tests/data/a1_focus.csv.

    python3 tests/python/a1_focus.py 100 > tests/data/a1_focus.csv      # two runs of 100 million rays, five minutes

Rays from the LED through the exact ball (unpolarised light, both polarisations by themselves, up to four reflections inside) that
land on the screen are counted where a pinhole sees them. Nothing is blurred. Facts of the scene: ../shared/peers/scenes/A1.json.
"""

import sys

import numpy as np

LED_SIDE, LUMINANCE = 0.2, 1e7  # mm, cd/m²
CENTRE, RADIUS, INDEX = np.array([0.0, 0.0, 12.0]), 3.0, 1.2
SCREEN_Z, SCREEN_HALF, REFLECTANCE = 40.0, 20.0, 0.5
EYE, TARGET, UP, HALF_FOV, SIDE = np.array([25.0, 10, 0]), np.array([0.0, -2, 40]), np.array([0.0, 1, 0]), np.radians(17), 128
ROWS, COLUMNS = slice(48, 64), slice(56, 72)
BATCH = 1_000_000
SIN2 = (3.25 / 12) ** 2  # of a cone that the ball lies in, as any point of the LED sees it


def dot(a, b):
    return (a * b).sum(1)


def fresnel(cos_in, n1, n2):
    """Reflectances (s, p) and the cosine behind the face."""
    cos_out = np.sqrt(np.maximum(1 - (n1 / n2) ** 2 * (1 - cos_in**2), 0))
    s = (n1 * cos_in - n2 * cos_out) / (n1 * cos_in + n2 * cos_out)
    p = (n2 * cos_in - n1 * cos_out) / (n2 * cos_in + n1 * cos_out)
    return np.array([s**2, p**2]), cos_out


def camera(points):
    """Row, column and luminance that a lumen on the screen at each point gives its pixel."""
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, UP)
    right /= np.linalg.norm(right)
    away = points - EYE
    depth, distance = away @ forward, np.sqrt(dot(away, away))
    tan = np.tan(HALF_FOV)
    column = np.floor((away @ right / depth / tan + 1) * SIDE / 2).astype(int)
    row = np.floor((1 - away @ np.cross(right, forward) / depth / tan) * SIDE / 2).astype(int)
    # A square of the screen as the picture's plane shows it, over a pixel there.
    solid_angle = away[:, 2] / distance / (distance * 1e-3) ** 2
    return row, column, REFLECTANCE / np.pi * solid_angle / (depth / distance) ** 3 / (2 * tan / SIDE) ** 2


def run(batches, seed):
    picture = np.zeros((SIDE, SIDE))
    shift = np.random.default_rng(seed).random(4)
    # Steps of an even sequence in four dimensions: powers of the root of x⁵ = x + 1 (Roberts 2018).
    root = 1.0
    for _ in range(60):
        root = (1 + root) ** 0.2
    for batch in range(batches):
        i = np.arange(batch * BATCH, (batch + 1) * BATCH, dtype=float)
        x = [(shift[k] + i * root ** -(k + 1)) % 1 for k in range(4)]
        sin, phi = np.sqrt(x[2] * SIN2), 2 * np.pi * x[3]
        origin = np.stack([(x[0] - 0.5) * LED_SIDE, (x[1] - 0.5) * LED_SIDE, np.zeros(BATCH)], 1)
        ray = np.stack([sin * np.cos(phi), sin * np.sin(phi), np.sqrt(1 - sin**2)], 1)
        lumens = LUMINANCE * (LED_SIDE * 1e-3) ** 2 * np.pi * SIN2 / (batches * BATCH)
        along = dot(origin - CENTRE, ray)
        chord = along**2 - dot(origin - CENTRE, origin - CENTRE) + RADIUS**2
        hit = chord > 0
        point = origin[hit] - ray[hit] * (along[hit] + np.sqrt(chord[hit]))[:, None]
        normal, ray = (point - CENTRE) / RADIUS, ray[hit]
        cos = -dot(ray, normal)
        reflected, beyond = fresnel(cos, 1, INDEX)
        ray = ray / INDEX + normal * (cos / INDEX - beyond)[:, None]
        light = 0.5 * lumens * (1 - reflected)
        for _ in range(5):
            point = point - 2 * dot(point - CENTRE, ray)[:, None] * ray
            normal = (point - CENTRE) / RADIUS
            cos = dot(ray, normal)
            reflected, beyond = fresnel(cos, INDEX, 1)
            out = ray * INDEX + normal * (beyond - INDEX * cos)[:, None]
            there = out[:, 2] > 0
            landed = point[there] + out[there] * ((SCREEN_Z - point[there, 2]) / out[there, 2])[:, None]
            lit = (light * (1 - reflected)).sum(0)[there]
            row, column, luminance = camera(landed)
            seen = (np.abs(landed[:, :2]) <= SCREEN_HALF).all(1) & (np.minimum(row, column) >= 0) & (np.maximum(row, column) < SIDE)
            np.add.at(picture, (row[seen], column[seen]), (lit * luminance)[seen])
            ray = ray - 2 * cos[:, None] * normal
            light = light * reflected
    return picture[ROWS, COLUMNS]


batches = int(sys.argv[1])
first, second = run(batches, 11), run(batches, 12)
differ = np.sqrt(((first - second) ** 2).sum() / (first * second).sum())
print("# Peers' scene A1 (samples/peers): luminance of the caustic where its focus is seen, cd/m²; rows 48 to 63, columns 56 to 71 of 128")
print(f"# made by tests/python/a1_focus.py, light tracing: two runs of {batches * BATCH:.0e} rays, which differ by {differ:.1e} of their root mean square")
for row in (first + second) / 2:
    print(",".join(f"{value:.6g}" for value in row))
