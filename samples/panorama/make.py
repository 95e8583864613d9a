#!/usr/bin/env python3
"""Makes the panoramas of samples/hud-*/colour.optics.toml: a town's street under a clear sky, and at dusk.

    python3 samples/panorama/make.py

Writes day.exr and dusk.exr beside this file. Everything is computed here; numpy is needed. CC0: do with it what you like.

Pixels are cd/m². The sky by day is that of Preetham, Shirley and Smits, "A practical analytic model for daylight",
SIGGRAPH 1999, as `sun_sky` has it, without the sun's disc, which is behind us. At dusk it is a choice of colours.
Everything below is cast into it: a ray for each quarter of a pixel.

Axes: y up, +z the middle of the picture, straight ahead, +x left. Metres; the eye is 1.2 m above the road.
"""
import math
import struct
import sys
import zlib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
WIDTH, FINE = 4096, 2
EYE = 1.2
ROAD = 1.9          # the road's middle: we drive on its right half
TURBIDITY, ELEVATION, AZIMUTH = 3.0, math.radians(38), math.radians(140)
SUN_LX = 78e3       # across the sun's light, as `sun_sky` has it at that height
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
rng = np.random.default_rng(40)


# Sky ------------------------------------------------------------------------------------------------------------------

TO_SUN = np.array([math.cos(ELEVATION) * math.sin(AZIMUTH), math.sin(ELEVATION),
                   math.cos(ELEVATION) * math.cos(AZIMUTH)])


class Day:
    """Preetham and others, appendix A.2. Colours are linear Rec.709, cd/m²."""

    name = "day"
    sun = SUN_LX * np.array([1.06, 0.99, 0.90])
    lit, lamps = 0.0, 0.0

    def __init__(self):
        t, s = TURBIDITY, math.pi / 2 - ELEVATION
        chi = (4 / 9 - t / 120) * (math.pi - 2 * s)
        zenith = 1e3 * ((4.0453 * t - 4.9710) * math.tan(chi) - 0.2155 * t + 2.4192)
        powers = np.array([s ** 3, s ** 2, s, 1])
        turbid = np.array([t * t, t, 1])
        x = turbid @ np.array([[0.00166, -0.00375, 0.00209, 0], [-0.02903, 0.06377, -0.03202, 0.00394],
                               [0.11693, -0.21196, 0.06052, 0.25886]]) @ powers
        y = turbid @ np.array([[0.00275, -0.00610, 0.00317, 0], [-0.04214, 0.08970, -0.04153, 0.00516],
                               [0.15346, -0.26756, 0.06670, 0.26688]]) @ powers
        rows = {
            "Y": [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
            "x": [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
            "y": [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
        }
        self.laws = {}
        for key, value in (("Y", zenith), ("x", x), ("y", y)):
            law = [slope * t + constant for slope, constant in rows[key]]
            self.laws[key] = (value / self.law(law, 1.0, s), law)

    @staticmethod
    def law(abcde, cos, angle):
        a, b, c, d, e = abcde
        return (1 + a * np.exp(b / cos)) * (1 + c * np.exp(d * angle) + e * np.cos(angle) ** 2)

    def sky(self, d):
        """Of directions above the horizon; lower ones as at the horizon."""
        cos = np.maximum(d[..., 1], 0.003)
        angle = np.arccos(np.clip(d @ TO_SUN, -1, 1))
        L, x, y = (scale * self.law(law, cos, angle) for scale, law in (self.laws[k] for k in "Yxy"))
        X, Z = x / y * L, (1 - x - y) / y * L
        rgb = [3.2406 * X - 1.5372 * L - 0.4986 * Z, -0.9689 * X + 1.8758 * L + 0.0415 * Z,
               0.0557 * X - 0.2040 * L + 1.0570 * Z]
        return np.maximum(np.stack(rgb, -1), 0)


class Dusk:
    """Half an hour after sunset, which was ahead to the right: chosen, not computed."""

    name = "dusk"
    sun = np.zeros(3)
    lit, lamps = 0.3, 9000.0

    def sky(self, d):
        height = np.clip(d[..., 1:2], 0, 1)
        ahead = 0.5 + 0.5 * (0.92 * d[..., 2:3] - 0.38 * d[..., 0:1])
        blue = np.array([9.0, 17.0, 40.0]) * (0.35 + 0.65 * np.exp(-2 * height))
        glow = np.array([220.0, 118.0, 52.0]) * ahead ** 3 * np.exp(-7 * height)
        return blue + glow


# Things ---------------------------------------------------------------------------------------------------------------

def hash_(*parts):
    """A number of 0 to 1 for integers."""
    h = np.uint32(2166136261)
    with np.errstate(over="ignore"):
        for part in parts:
            h = (h ^ np.asarray(part).astype(np.int64).astype(np.uint32)) * np.uint32(16777619)
            h = h ^ (h >> np.uint32(15))
        h = h * np.uint32(2246822519)
        h = h ^ (h >> np.uint32(13))
    return h / 2.0 ** 32


class Box:
    def __init__(self, lo, hi, kind, colour, bay=3.0, storey=3.4, share=(0.55, 0.55), seed=0):
        self.lo, self.hi = np.array(lo, float), np.array(hi, float)
        self.kind, self.colour, self.seed = kind, np.array(colour), seed
        self.bay, self.storey, self.share = bay, storey, share


def town():
    walls = [(0.42, 0.20, 0.14), (0.52, 0.42, 0.29), (0.36, 0.34, 0.31),
             (0.56, 0.50, 0.41), (0.28, 0.22, 0.19), (0.50, 0.32, 0.22)]
    boxes, seed = [], 0

    def house(x0, x1, z0, z1, height, tall=False):
        nonlocal seed
        seed += 1
        wall = (0.34, 0.38, 0.42) if tall else walls[int(rng.integers(len(walls)))]
        share = (0.8, 0.72) if tall else (rng.uniform(0.38, 0.58), rng.uniform(0.48, 0.6))
        boxes.append(Box((x0, -EYE, z0), (x1, height - EYE, z1), "house", wall,
                         rng.uniform(2.4, 3.6), rng.uniform(3.1, 3.7), share, seed))
        if not tall:
            boxes.append(Box((x0 - 0.35, height - EYE - 0.5, z0 - 0.35), (x1 + 0.35, height - EYE, z1 + 0.35), "plain",
                             np.array(wall) * 1.15))
            if rng.random() < 0.6:
                top = height - EYE
                boxes.append(Box((x0 + 3, top, z0 + 2), (x0 + 8, top + 2.6, z0 + 7), "plain", (0.4, 0.4, 0.4)))

    for side in (-1, 1):
        z = -300.0
        while z < 620:
            depth = rng.uniform(14, 30)
            if rng.random() < 0.14:
                z += rng.uniform(8, 16)
            front = ROAD + side * (15.0 + rng.choice([0, 0, 0, 1.5, 4.0]))
            back = front + side * rng.uniform(14, 22)
            x0, x1 = sorted((front, back))
            if z + depth < -16 or z > 14:
                house(x0, x1, z, z + depth, 3.4 * rng.integers(3, 8) + 1.2)
            z += depth + 0.02
    # The street ends at a crossroads; towers beyond and all around.
    for _ in range(150):
        angle, distance = rng.uniform(-math.pi, math.pi), rng.uniform(750, 2600)
        x, z = distance * math.sin(angle), distance * math.cos(angle)
        w, d = rng.uniform(18, 55, 2)
        house(x - w, x + w, z - d, z + d, rng.gamma(3.0, 22.0) + 12, rng.random() < 0.5)
    for x, z, w, h in ((-26, 1100, 20, 120), (38, 1350, 24, 165), (4, 1700, 18, 210), (-70, 1500, 26, 140),
                       (90, 1200, 22, 95), (-130, 1250, 30, 110), (150, 1600, 30, 150)):
        house(x - w, x + w, z, z + 2 * w, h, True)
    spheres = []
    for side in (-1, 1):
        for k in range(34):
            z = -150 + 16 * k + (7 if side > 0 else 0)
            x = ROAD + side * 10.6
            if -9 < z < 9:
                continue
            height = rng.uniform(4.6, 6.0)
            crown = np.array([x, height - EYE, z])
            boxes.append(Box((x - 0.16, -EYE, z - 0.16), crown + 0.16, "plain", (0.16, 0.12, 0.09)))
            for _ in range(110):
                d = rng.normal(size=3)
                p = crown + d / np.linalg.norm(d) * rng.uniform(0.5, 1) ** 0.5 * np.array([2.0, 1.7, 2.0])
                spheres.append((p, rng.uniform(0.2, 0.5), np.array([0.10, 0.15, 0.045]) * rng.uniform(0.7, 1.45)))
        for k in range(14):
            z = -120 + 32 * k + (16 if side > 0 else 0)
            x = ROAD + side * 8.6
            boxes.append(Box((x - 0.08, -EYE, z - 0.08), (x + 0.08, 7.2 - EYE, z + 0.08), "plain", (0.22, 0.23, 0.24)))
            a, b = sorted((x, x - side * 2.0))
            boxes.append(Box((a, 7.1 - EYE, z - 0.06), (b, 7.2 - EYE, z + 0.06), "plain", (0.22, 0.23, 0.24)))
            a, b = sorted((x - side * 1.3, x - side * 2.1))
            boxes.append(Box((a, 7.0 - EYE, z - 0.16), (b, 7.1 - EYE, z + 0.16), "lamp", (0.3, 0.3, 0.3)))
    return boxes, spheres


def shadow_map(boxes, spheres):
    """What of the ground the sun does not see: cells of 0.2 m."""
    x0, z0, cell = -40.0, -320.0, 0.2
    xs, zs = x0 + cell * (np.arange(420) + 0.5), z0 + cell * (np.arange(4900) + 0.5)
    dark = np.zeros((len(zs), len(xs)), bool)
    slope = TO_SUN / TO_SUN[1]
    for box in boxes:
        # The shadow of a box is swept by its section from the ground up.
        top = box.hi[1] + EYE
        bottom = max(box.lo[1] + EYE, 0)
        if np.abs((box.lo[0] + box.hi[0]) / 2) > 60 + top * 2:
            continue
        steps = max(2, int((top - bottom) / 0.25) + 1)
        for h in np.linspace(bottom, top, steps):
            a = ((box.lo[[0, 2]] - h * slope[[0, 2]] - [x0, z0]) / cell).astype(int)
            b = ((box.hi[[0, 2]] - h * slope[[0, 2]] - [x0, z0]) / cell).astype(int) + 1
            a, b = np.maximum(a, 0), np.maximum(b, 0)
            dark[a[1]:b[1], a[0]:b[0]] = True
    for p, r, _ in spheres:
        c = (p[[0, 2]] - (p[1] + EYE) * slope[[0, 2]] - [x0, z0]) / cell
        n = int(r / cell) + 1
        i, j = np.round(c).astype(int)
        for dj in range(-n, n + 1):
            for di in range(-n, n + 1):
                if (di * di + dj * dj) * cell * cell < r * r and 0 <= j + dj < len(zs) and 0 <= i + di < len(xs):
                    dark[j + dj, i + di] = True
    return dark, (x0, z0, cell)


# Rays -----------------------------------------------------------------------------------------------------------------

def directions(rows, width, height):
    polar = np.pi * (rows[:, None] + 0.5) / height
    lon = np.pi - 2 * np.pi * (np.arange(width)[None, :] + 0.5) / width
    s = np.sin(polar)
    return np.stack([s * np.sin(lon), np.broadcast_to(np.cos(polar), (len(rows), width)), s * np.cos(lon)], -1)


class Picture:
    def __init__(self, light, things):
        self.light = light
        self.boxes, self.spheres, (self.dark, self.map) = things
        # Light from the sky on a plane that looks up, and as much as a wall gets of sky and ground.
        d = rng_free_sphere()
        up = d[:, 1] > 0
        self.ambient = 2 * np.pi * (light.sky(d[up]) * d[up][:, 1:2]).mean(0)

    def lamps_at(self, x, z):
        """Illuminance of the ground under the street's lamps, lx; by no formula but that of one lamp per place."""
        if not self.light.lamps:
            return np.zeros(np.shape(x) + (1,))
        e = np.zeros(np.shape(x))
        for side in (-1, 1):
            along = (z + 120 - (16 if side > 0 else 0)) % 32
            along = np.minimum(along, 32 - along)
            across = x - (ROAD + side * 6.9)
            e += 26.0 * (1 + (along ** 2 + across ** 2) / 49.0) ** -2
        return e[..., None]

    def haze(self, colour, d, distance):
        level = d * np.array([1, 0, 1]) + np.array([0, 0.02, 0])
        level /= np.linalg.norm(level, axis=-1, keepdims=True)
        through = np.exp(-distance / 7000.0)[..., None]
        return colour * through + 0.8 * self.light.sky(level) * (1 - through)

    def ground(self, d):
        t = EYE / np.maximum(-d[..., 1], 1e-5)
        x, z = d[..., 0] * t, d[..., 2] * t
        across = np.abs(x - ROAD)
        fine = hash_(np.floor(x * 12), np.floor(z * 12), 1)
        coarse = hash_(np.floor(x / 1.7), np.floor(z / 2.9), 2)
        # What lies before our feet is seen by nobody and stays plain: noise makes files large.
        near = np.exp(-t / 60.0) * np.clip((t - 5) / 5, 0, 1)
        a = 0.085 * (1 + 0.3 * near * (fine - 0.5) + 0.05 * (coarse - 0.5) * np.clip((t - 5) / 5, 0, 1))
        # Wheels polish two tracks of each lane.
        lane = np.abs(np.mod(across, 3.75) - 1.875)
        a *= 1 + 0.10 * np.exp(-((lane - 0.8) / 0.3) ** 2)
        albedo = a[..., None] * np.array([1.0, 0.99, 0.97])
        paint = ((across < 0.08) & (np.mod(z, 9) < 9)) | ((np.abs(across - 3.75) < 0.07) & (np.mod(z, 12) < 5)) \
            | (np.abs(across - 7.25) < 0.07)
        paint |= (across < 7.0) & (np.abs(z - 27) < 2) & (np.mod(x, 1.0) < 0.5)
        paint |= (across < 3.7) & (x < ROAD) & (np.abs(z - 23.5) < 0.2)
        albedo = np.where((paint & (across < 7.5))[..., None], np.array([0.52, 0.52, 0.50]), albedo)
        stone = 0.26 + 0.06 * (hash_(np.floor(x / 0.5), np.floor(z / 0.5), 3) - 0.5) * near
        walk = across > 7.5
        albedo = np.where(walk[..., None], stone[..., None] * np.array([1.0, 0.97, 0.92]), albedo)
        kerb = (across > 7.5) & (across < 7.7)
        albedo = np.where(kerb[..., None], np.array([0.34, 0.34, 0.33]), albedo)
        lawn = (across > 9.7) & (across < 11.5) & (np.mod(z + 2, 16) > 4)
        green = np.array([0.075, 0.115, 0.04]) * (1 + 0.5 * near * (fine - 0.5))[..., None]
        albedo = np.where(lawn[..., None], green, albedo)
        away = (across > 60) | (np.abs(z - 150) > 520)
        albedo = np.where(away[..., None], np.array([0.12, 0.13, 0.10]), albedo)
        x0, z0, cell = self.map
        i, j = ((x - x0) / cell).astype(np.int64), ((z - z0) / cell).astype(np.int64)
        inside = (i >= 0) & (j >= 0) & (i < self.dark.shape[1]) & (j < self.dark.shape[0])
        dark = inside & self.dark[np.where(inside, j, 0), np.where(inside, i, 0)]
        e = self.ambient * 0.75 + (~dark)[..., None] * self.light.sun * TO_SUN[1] + self.lamps_at(x, z)
        return self.haze(albedo * e / np.pi, d, t)

    def shade(self, box, d, t, n):
        p = d * t[..., None]
        sun = np.maximum(n @ TO_SUN, 0)[..., None]
        sky = (0.5 + 0.5 * n[..., 1:2])
        e = self.ambient * (0.25 + 0.6 * sky) + sun * self.light.sun
        height = p[..., 1] + EYE
        e = e + self.lamps_at(p[..., 0], p[..., 2]) * np.exp(-height / 5.0)[..., None] * 0.7
        if box.kind == "lamp":
            down = (n[..., 1] < -0.5)[..., None] & (self.light.lamps > 0)
            return np.where(down, self.light.lamps * np.array([1.25, 0.95, 0.65]), box.colour * e / np.pi)
        wall = box.colour * e / np.pi
        if box.kind != "house":
            return wall
        side = np.abs(n[..., 1]) < 0.5
        along_x = np.abs(n[..., 0]) < 0.5
        u = np.where(along_x, p[..., 0] - box.lo[0], p[..., 2] - box.lo[2])
        length = np.where(along_x, box.hi[0] - box.lo[0], box.hi[2] - box.lo[2])
        bays = np.maximum(np.round(length / box.bay), 1)
        s = u / length * bays
        shop = height < 3.9
        v = (height - 0.5) / box.storey
        column, row = np.floor(s), np.where(shop, -1, np.floor(v))
        fs, fv = np.abs(s - column - 0.5), np.abs(v - np.floor(v) - 0.5)
        wide = np.where(shop, 0.8, box.share[0])
        pane = (fs < wide / 2) & np.where(shop, (height > 0.6) & (height < 3.1), fv < box.share[1] / 2)
        pane &= side & (height < box.hi[1] + EYE - 0.9)
        rim = np.where(shop, (height > 0.45) & (height < 3.25), fv < box.share[1] / 2 + 0.035) & (fs < wide / 2 + 0.035)
        rim &= side & ~pane & (t < 400)
        bar = pane & (fs < 0.018) & (t < 400)
        key = hash_(column, row, np.where(along_x, 5, 6), box.seed)
        # Panes mirror what is across: the sky, or near the ground the other side of the street; behind them it is dark.
        mirrored = d - 2 * (d * n).sum(-1, keepdims=True) * n
        cos = np.abs((d * n).sum(-1))
        fresnel = (0.08 + 0.92 * (1 - cos) ** 5)[..., None]
        across = 0.16 * (self.ambient + 0.5 * self.light.sun) / np.pi
        view = np.where(mirrored[..., 1:2] > 0.22, self.light.sky(mirrored), across)
        room = (0.02 + 0.05 * key ** 2)[..., None] * e / np.pi
        room = np.where((key > 0.8)[..., None] & ~shop[..., None], 0.3 * e / np.pi, room)
        on = hash_(column, row, 9, box.seed) < np.where(shop, 1.6 * self.light.lit, self.light.lit)
        glow = np.array([1.35, 0.93, 0.5]) * ((60 + 240 * key) * np.where(t < 650, 1, 0.3))[..., None]
        glass = view * fresnel + room + np.where(on[..., None], glow, 0)
        tone = 1 + 0.16 * (hash_(np.floor(u * 3), np.floor(height * 6), 4, box.seed) - 0.5) * np.exp(-t / 70)
        ledge = side & (np.abs(v - np.floor(v) - 0.03) < 0.03) & ~shop
        wall = wall * np.where(ledge, 1.18, tone)[..., None]
        frame = 0.62 * e / np.pi
        return np.where((pane & ~bar)[..., None], glass, np.where((rim | bar)[..., None], frame, wall))

    def band(self, first, last, width, height):
        rows = np.arange(first, last)
        d = directions(rows, width, height)
        colour = np.where(d[..., 1:2] > 0, self.light.sky(d), 0)
        depth = np.full(d.shape[:2], np.inf)
        low = np.nonzero(rows >= height // 2)[0]
        if len(low):
            k = low[0]
            colour[k:] = self.ground(d[k:])
            depth[k:] = EYE / np.maximum(-d[k:, :, 1], 1e-5)

        def window(points):
            """Rows and columns that points are within; columns may go round."""
            r = np.linalg.norm(points, axis=1)
            polar = np.arccos(np.clip(points[:, 1] / r, -1, 1)) / np.pi * height
            lon = np.arctan2(points[:, 0], points[:, 2])
            column = (0.5 - lon / (2 * np.pi)) * width
            if column.max() - column.min() > width / 2:
                column = np.where(column < width / 2, column + width, column)
            a, b = int(max(polar.min() - 3, first)) - first, int(min(polar.max() + 4, last)) - first
            return a, b, np.arange(int(column.min()) - 3, int(column.max()) + 4) % width

        for box in self.boxes:
            # Edges and faces by points: a straight edge is bent in the picture.
            g = np.linspace(0, 1, 9)
            grid = np.stack(np.meshgrid(g, g, g, indexing="ij"), -1).reshape(-1, 3)
            grid = grid[((grid == 0) | (grid == 1)).any(1)]
            a, b, columns = window(box.lo + grid * (box.hi - box.lo))
            if a >= b:
                continue
            rays = d[a:b][:, columns]
            with np.errstate(divide="ignore", invalid="ignore"):
                t0, t1 = box.lo / rays, box.hi / rays
            enter, leave = np.minimum(t0, t1), np.maximum(t0, t1)
            axis = enter.argmax(-1)
            t = enter.max(-1)
            hit = (t > 0) & (t < leave.min(-1)) & (t < depth[a:b][:, columns])
            if not hit.any():
                continue
            y, x = np.nonzero(hit)
            of, at, ax = rays[y, x], t[y, x], axis[y, x]
            n = np.zeros_like(of)
            n[np.arange(len(ax)), ax] = -np.sign(of[np.arange(len(ax)), ax])
            colour[a + y, columns[x]] = self.haze(self.shade(box, of, at, n), of, at)
            depth[a + y, columns[x]] = at
        for centre, radius, albedo in self.spheres:
            spread = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * radius
            a, b, columns = window(centre + spread)
            if a >= b:
                continue
            rays = d[a:b][:, columns]
            along = rays @ centre
            rest = along ** 2 - centre @ centre + radius ** 2
            t = along - np.sqrt(np.maximum(rest, 0))
            hit = (rest > 0) & (t > 0) & (t < depth[a:b][:, columns])
            if not hit.any():
                continue
            y, x = np.nonzero(hit)
            of, at = rays[y, x], t[y, x]
            n = (of * at[:, None] - centre) / radius
            p = of * at[:, None]
            leaf = hash_(np.floor(p[:, 0] * 25), np.floor(p[:, 1] * 25), np.floor(p[:, 2] * 25))[:, None]
            sun = np.maximum(n @ TO_SUN + 0.15, 0)[:, None] * (leaf > 0.25)
            e = self.ambient * (0.35 + 0.35 * n[:, 1:2]) + sun * self.light.sun + 0.5 * self.lamps_at(p[:, 0], p[:, 2])
            colour[a + y, columns[x]] = self.haze(albedo * (0.6 + 0.8 * leaf) * e / np.pi, of, at)
            depth[a + y, columns[x]] = at
        return colour

    def render(self, width):
        height = width // 2
        out = np.zeros((height, width, 3), np.float32)
        step = 64
        for first in range(0, height, step):
            fine = self.band(first * FINE, (first + step) * FINE, width * FINE, height * FINE)
            out[first:first + step] = fine.reshape(step, FINE, width, FINE, 3).mean((1, 3))
            print(f"\r{self.light.name}: {100 * (first + step) // height} %", end="", file=sys.stderr)
        print(file=sys.stderr)
        return out


def rng_free_sphere():
    """Even directions: a Fibonacci lattice."""
    k = np.arange(4096) + 0.5
    y, lon = 1 - 2 * k / 4096, k * math.pi * (3 - math.sqrt(5))
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.sin(lon), y, r * np.cos(lon)], -1)


# OpenEXR --------------------------------------------------------------------------------------------------------------

def exr(path, channels):
    """Half floats, scan lines, ZIP in blocks of 16. `channels`: name to (array, pixels each way that share a value)."""
    names = sorted(channels)
    height, width = (n * channels[names[0]][1] for n in channels[names[0]][0].shape)

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 1, 0, *[channels[n][1]] * 2) for n in names) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", listed)
    head += attribute("compression", "compression", b"\3") + attribute("dataWindow", "box2i", window)
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", b"\0" * 8)
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    blocks = []
    for first in range(0, height, 16):
        raw = b""
        for y in range(first, first + 16):
            for values, share in (channels[n] for n in names):
                if y % share == 0:
                    raw += values[y // share].astype("<f2").tobytes()
        raw = np.frombuffer(raw, np.uint8)
        split = np.concatenate([raw[0::2], raw[1::2]]).astype(np.int16)
        split[1:] = (split[1:] - split[:-1] + 128) & 255
        packed = zlib.compress(split.astype(np.uint8).tobytes(), 9)
        packed = packed if len(packed) < len(raw) else raw.tobytes()
        blocks.append(struct.pack("<ii", first, len(packed)) + packed)
    offset = len(head) + 8 * len(blocks)
    table = b""
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    path.write_bytes(head + table + b"".join(blocks))


def rounded(values, bits):
    """To so many binary digits behind the first: smooth skies then compress to a third."""
    step = 2.0 ** (np.floor(np.log2(np.maximum(np.abs(values), 1e-3))) - bits)
    return np.round(values / step) * step


def fourth(values):
    height, width = values.shape
    return values.reshape(height // 2, 2, width // 2, 2).mean((1, 3))


def luminance_chroma(rgb):
    """As OpenEXR has it: (R - Y)/Y and (B - Y)/Y, four pixels share theirs."""
    small = np.stack([fourth(rgb[..., k]) for k in range(3)], -1)
    grey = small @ LUMINANCE
    chroma = {name: np.round(256 * (small[..., k] - grey) / grey) / 256 for name, k in (("RY", 0), ("BY", 2))}
    return {"Y": (rounded(rgb @ LUMINANCE, 7), 1)} | {name: (values, 2) for name, values in chroma.items()}


def main():
    boxes, spheres = town()
    things = boxes, spheres, shadow_map(boxes, spheres)
    for light in (Day(), Dusk()):
        colours = Picture(light, things).render(WIDTH)
        exr(HERE / f"{light.name}.exr", luminance_chroma(colours))
        grey = colours @ LUMINANCE
        print(f"{light.name}: {grey.min():.3g} to {grey.max():.5g} cd/m²", file=sys.stderr)


if __name__ == "__main__":
    main()
