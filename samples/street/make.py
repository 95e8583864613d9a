#!/usr/bin/env python3
"""Makes samples/street: a street by day and by dusk, seen from a car, and the head-up display of samples/hud-direct in it.

    python3 samples/street/make.py

Everything is computed here, with Python alone: street.usda and its textures. scene.usda, which puts the display in front of
the driver's eye, and the sidecars are written by hand. CC0: do with it what you like.

Metres, y up; the driver's eye is the origin and looks along -z. The road lies 1.2 m below.
"""
import math
import os
import random
import struct
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
ROAD = -1.2
rng = random.Random(8)


# Textures -------------------------------------------------------------------------------------------------------------

def png(name, width, height, pixel, channels=3):
    """pixel(x, y) -> channels numbers of 0 to 1, as they are stored."""
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            rows.extend(max(0, min(255, int(v * 255 + 0.5))) for v in pixel(x, y))
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    kind = {1: 0, 3: 2, 4: 6}[channels]
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    with open(os.path.join(HERE, "textures", name), "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b""))


def lattice(seed, size):
    r = random.Random(seed)
    return [[r.random() for _ in range(size)] for _ in range(size)]


def noise(grid, x, y):
    """Smooth noise that repeats with the grid."""
    n = len(grid)
    i, j = int(math.floor(x)), int(math.floor(y))
    s, t = x - i, y - j
    s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)
    a, b = grid[j % n][i % n], grid[j % n][(i + 1) % n]
    c, d = grid[(j + 1) % n][i % n], grid[(j + 1) % n][(i + 1) % n]
    return (a + (b - a) * s) * (1 - t) + (c + (d - c) * s) * t


def textures():
    os.makedirs(os.path.join(HERE, "textures"), exist_ok=True)
    fine, coarse = lattice(1, 128), lattice(2, 8)
    def asphalt(x, y):
        v = 0.26 + 0.12 * (noise(fine, x / 2, y / 2) - 0.5) + 0.06 * (noise(coarse, x / 32, y / 32) - 0.5)
        return v, v, v * 1.03
    png("asphalt.png", 256, 256, asphalt)

    def paving(x, y):
        row = y // 32
        shift = 32 if row % 2 else 0
        joint = y % 32 < 2 or (x + shift) % 64 < 2
        tone = random.Random((row * 977 + ((x + shift) % 256) // 64) * 31).random()
        v = 0.33 if joint else 0.55 + 0.12 * tone + 0.08 * (noise(fine, x / 2, y / 2) - 0.5)
        return v, v * 0.97, v * 0.92
    png("paving.png", 256, 256, paving)

    # A facade of 4 by 4 windows: colour, and metallic (blue) with roughness (green), so that panes mirror the sky.
    def facade(base, frame, brick):
        def parts(x, y):
            u, v = x % 64, y % 64
            pane = 18 <= u < 46 and 14 <= v < 50
            bar = pane and (30 <= u < 34 or 30 <= v < 33)
            rim = not pane and 15 <= u < 49 and 11 <= v < 54
            return pane and not bar, bar or rim
        def colour(x, y):
            pane, rim = parts(x, y)
            if pane:
                lit = random.Random((x // 64) * 7 + (y // 64) * 13 + int(base[0] * 100)).random()
                v = 0.14 + 0.1 * lit
                return v, v * 1.05, v * 1.12
            if rim:
                return frame
            k = 1 + 0.25 * (noise(fine, x / 3, y / 3) - 0.5) + 0.2 * (noise(coarse, x / 32, y / 32) - 0.5)
            if brick:
                row = y // 6
                if y % 6 == 0 or (x + (6 if row % 2 else 0)) % 12 == 0:
                    k *= 1.25
            return tuple(c * k for c in base)
        def surface(x, y):
            pane, rim = parts(x, y)
            return (0, 0.05, 0.0) if pane else (0, 0.5, 0.0) if rim else (0, 0.9, 0.0)
        return colour, surface
    looks = {
        "brick": ((0.56, 0.30, 0.24), (0.85, 0.84, 0.80), True),
        "plaster": ((0.82, 0.76, 0.62), (0.92, 0.92, 0.90), False),
        "stone": ((0.62, 0.62, 0.60), (0.30, 0.32, 0.33), False),
    }
    for name, (base, frame, brick) in looks.items():
        colour, surface = facade(base, frame, brick)
        png(f"{name}.png", 256, 256, colour)
        png(f"{name}_surface.png", 256, 256, surface)

    # Leaves: a scatter of ellipses, with alpha.
    leaves = [(rng.random() * 128, rng.random() * 128, rng.random() * math.pi, 5 + 5 * rng.random(), rng.random())
              for _ in range(120)]
    best = [[None] * 128 for _ in range(128)]
    for cx, cy, turn, size, tone in leaves:
        c, s = math.cos(turn), math.sin(turn)
        for dy in range(-10, 11):
            for dx in range(-10, 11):
                u, v = (c * dx + s * dy) / size, (c * dy - s * dx) / (size * 0.45)
                if u * u + v * v < 1:
                    best[int(cy + dy) % 128][int(cx + dx) % 128] = (tone, abs(v))
    def leaf(x, y):
        found = best[y][x]
        if found is None:
            return 0.3, 0.42, 0.15, 0
        tone, rib = found
        k = 0.8 + 0.35 * tone - 0.2 * (rib < 0.12)
        return 0.32 * k, 0.47 * k, 0.17 * k, 1
    png("leaves.png", 128, 128, leaf, 4)

    # Normals of grained plastic, for the dashboard.
    grain = lattice(5, 64)
    def height(x, y):
        return noise(grain, x / 2, y / 2)
    def normal(x, y):
        dx, dy = height(x + 1, y) - height(x - 1, y), height(x, y + 1) - height(x, y - 1)
        n = (-dx * 0.6, dy * 0.6, 1.0)
        k = math.sqrt(sum(v * v for v in n))
        return tuple(0.5 + 0.5 * v / k for v in n)
    png("grain_normal.png", 128, 128, normal)


# Geometry -------------------------------------------------------------------------------------------------------------

class Mesh:
    def __init__(self, name, material, double_sided=False):
        self.name, self.material, self.double_sided = name, material, double_sided
        self.points, self.st, self.counts, self.indices = [], [], [], []

    def face(self, corners, st):
        first = len(self.points)
        self.points.extend(corners)
        self.st.extend(st)
        self.counts.append(len(corners))
        self.indices.extend(range(first, first + len(corners)))

    def quad(self, a, b, c, d, s=1.0, t=1.0):
        self.face([a, b, c, d], [(0, 0), (s, 0), (s, t), (0, t)])

    def box(self, lo, hi, scale=1.0):
        """Outward faces; a texture unit is `scale` metres."""
        (x0, y0, z0), (x1, y1, z1) = lo, hi
        w, h, d = (x1 - x0) / scale, (y1 - y0) / scale, (z1 - z0) / scale
        self.quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1), w, h)
        self.quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0), w, h)
        self.quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1), d, h)
        self.quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0), d, h)
        self.quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0), w, d)
        self.quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1), w, d)

    def loft(self, rings, closed, t_scale=1.0):
        """Quads between rows of points, outwards if the rows run counter-clockwise seen from where they go."""
        for k in range(len(rings) - 1):
            a, b = rings[k], rings[k + 1]
            n = len(a)
            for i in range(n if closed else n - 1):
                j = (i + 1) % n
                s0, s1 = i / n, (i + 1) / n
                t0, t1 = k * t_scale / (len(rings) - 1), (k + 1) * t_scale / (len(rings) - 1)
                self.face([a[i], a[j], b[j], b[i]], [(s0, t0), (s1, t0), (s1, t1), (s0, t1)])

    def usda(self, indent):
        pad = " " * indent
        def vectors(all_):
            return ", ".join("(" + ", ".join(f"{v:.4g}" for v in p) + ")" for p in all_)
        lines = [
            f'def Mesh "{self.name}" (prepend apiSchemas = ["MaterialBindingAPI"])', "{",
            f"    rel material:binding = </street/materials/{self.material}>",
            '    uniform token subdivisionScheme = "none"',
            f"    int[] faceVertexCounts = [{', '.join(map(str, self.counts))}]",
            f"    int[] faceVertexIndices = [{', '.join(map(str, self.indices))}]",
            f"    point3f[] points = [{vectors(self.points)}]",
            f'    texCoord2f[] primvars:st = [{vectors(self.st)}] (interpolation = "vertex")',
        ]
        if self.double_sided:
            lines.append("    uniform bool doubleSided = 1")
        return "\n".join(pad + line for line in lines + ["}"])


def ring(centre, radius, y, n=10):
    x, z = centre
    return [(x + radius * math.sin(2 * math.pi * i / n), y, z + radius * math.cos(2 * math.pi * i / n)) for i in range(n)]


def street():
    meshes = []
    road = Mesh("road", "asphalt")
    road.quad((-5, ROAD, 8), (5, ROAD, 8), (5, ROAD, -160), (-5, ROAD, -160), 5, 84)
    marks = Mesh("markings", "paint")
    lift = ROAD + 0.004
    for k in range(24):
        z = 4 - 7 * k
        marks.quad((-1.66, lift, z), (-1.54, lift, z), (-1.54, lift, z - 3), (-1.66, lift, z - 3))
    for x in (-4.7, 4.58):
        marks.quad((x, lift, 8), (x + 0.12, lift, 8), (x + 0.12, lift, -160), (x, lift, -160))
    for k in range(7):
        x = -4.2 + 1.35 * k
        marks.quad((x, lift, -28), (x + 0.6, lift, -28), (x + 0.6, lift, -31.5), (x, lift, -31.5))
    kerb, walk = Mesh("kerb", "concrete"), Mesh("pavement", "paving")
    for side in (-1, 1):
        inner, outer = sorted((5 * side, 5.25 * side))
        kerb.box((inner, ROAD - 0.1, -160), (outer, ROAD + 0.14, 8), 2)
        a, b = sorted((5.25 * side, 9 * side))
        walk.quad((a, ROAD + 0.14, 8), (b, ROAD + 0.14, 8), (b, ROAD + 0.14, -160), (a, ROAD + 0.14, -160), 2.5, 112)
    meshes += [road, marks, kerb, walk]

    facades = {name: Mesh(f"houses_{name}", name) for name in ("brick", "plaster", "stone")}
    roofs = Mesh("roofs", "roof")
    names = list(facades)
    for side in (-1, 1):
        z, k = 6.0, 0 if side < 0 else 1
        while z > -160:
            depth = 9 + 8 * rng.random()
            height = ROAD + 0.14 + 3.2 * (3 + int(3 * rng.random()))
            front, back = 9.0 * side, 21.0 * side
            lo, hi = sorted((front, back))
            facades[names[k % 3]].box((lo, ROAD, z - depth), (hi, height, z), 12.8)
            roofs.box((lo - 0.3, height, z - depth), (hi + 0.3, height + 0.35, z), 2)
            z -= depth + (4.5 if rng.random() < 0.2 else 0.0)
            k += 1
    facades["stone"].box((-16, ROAD, -176), (16, ROAD + 16, -166), 12.8)
    meshes += list(facades.values()) + [roofs]

    trunks, crowns = Mesh("trunks", "bark"), Mesh("crowns", "leaves", True)
    lamps, heads = Mesh("lamp_posts", "metal"), Mesh("lamp_heads", "lamp")
    for k in range(9):
        for side in (-1, 1):
            z = -9 - 16 * k - (5 if side > 0 else 0)
            x = 6.6 * side
            foot = ROAD + 0.14
            trunks.loft([ring((x, z), r, foot + h) for r, h in ((0.2, 0), (0.15, 1.2), (0.12, 2.6), (0.05, 4.2))], True)
            for _ in range(46):
                # A card at a random place of a ball, turned any way.
                d = [rng.gauss(0, 1) for _ in range(3)]
                n = math.sqrt(sum(v * v for v in d))
                r = 1.75 * rng.random() ** (1 / 3)
                cx, cy, cz = x + r * d[0] / n, foot + 3.9 + 0.85 * r * d[1] / n, z + r * d[2] / n
                a, b = rng.random() * 2 * math.pi, (rng.random() - 0.5) * 1.6
                u = (0.62 * math.cos(a), 0.0, 0.62 * math.sin(a))
                v = (-0.62 * math.sin(b) * math.sin(a), 0.62 * math.cos(b), 0.62 * math.sin(b) * math.cos(a))
                corner = lambda s, t: (cx + s * u[0] + t * v[0], cy + s * u[1] + t * v[1], cz + s * u[2] + t * v[2])
                crowns.quad(corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1))
            z -= 8
            x = 5.6 * side
            lamps.loft([ring((x, z), 0.06, foot + h, 8) for h in (0, 6.4)], True)
            arm = sorted((x, x - 1.6 * side))
            lamps.box((arm[0], foot + 6.4, z - 0.05), (arm[1], foot + 6.5, z + 0.05))
            x -= 1.3 * side
            heads.quad((x - 0.3, foot + 6.39, z - 0.14), (x + 0.3, foot + 6.39, z - 0.14),
                       (x + 0.3, foot + 6.39, z + 0.14), (x - 0.3, foot + 6.39, z + 0.14))
    meshes += [trunks, crowns, lamps, heads]
    meshes += car((1.2, -21.0), "blue", 1) + car((-3.4, -34.0), "red", -1)
    return meshes


def car(place, paint, ahead):
    """A saloon from sections across; `ahead` = 1 drives away from us."""
    x0, z0 = place
    ground = ROAD
    body = Mesh(f"car_{paint}_body", f"paint_{paint}")
    # (along, half width, bottom, top): a rounded section each.
    sections = [(-2.1, 0.70, 0.42, 0.80), (-2.0, 0.82, 0.30, 0.92), (-1.2, 0.88, 0.25, 0.98), (0.0, 0.89, 0.25, 1.0),
                (1.2, 0.88, 0.25, 0.95), (2.0, 0.80, 0.30, 0.85), (2.1, 0.70, 0.42, 0.74)]
    def section(along, half, low, high):
        out = []
        for i in range(16):
            a = 2 * math.pi * i / 16
            c, s = math.cos(a), math.sin(a)
            px = half * math.copysign(abs(c) ** 0.4, c)
            py = (low + high) / 2 + (high - low) / 2 * math.copysign(abs(s) ** 0.5, s)
            out.append((x0 + px, ground + py, z0 - ahead * along))
        return out if ahead > 0 else out[::-1]
    rows = [section(*s) for s in sections]
    body.loft(rows, True)
    body.face(rows[0][::-1], [(0, 0)] * 16)
    body.face(rows[-1], [(0, 0)] * 16)
    glass = Mesh(f"car_{paint}_glass", "tinted")
    top = [(-1.5, 0.78, 0.9, 0.98), (-0.9, 0.68, 0.9, 1.42), (0.3, 0.68, 0.9, 1.44), (1.1, 0.78, 0.9, 0.98)]
    rows = [section(*s) for s in top]
    glass.loft(rows, True)
    roof = Mesh(f"car_{paint}_roof", f"paint_{paint}")
    z = sorted((z0 - ahead * -0.85, z0 - ahead * 0.25))
    roof.box((x0 - 0.62, ground + 1.41, z[0]), (x0 + 0.62, ground + 1.46, z[1]))
    wheels = Mesh(f"car_{paint}_wheels", "rubber")
    for along in (-1.3, 1.35):
        for side in (-1, 1):
            cx, cz = x0 + 0.8 * side, z0 - ahead * along
            def wheel(dx, r):
                return [(cx + dx, ground + 0.32 + r * math.cos(2 * math.pi * i / 16), cz + r * math.sin(2 * math.pi * i / 16))
                        for i in range(16)]
            wheels.loft([wheel(-0.1, 0.02), wheel(-0.1, 0.32), wheel(0.1, 0.32), wheel(0.1, 0.02)], True)
    lights = Mesh(f"car_{paint}_lights", "tail" if ahead > 0 else "head")
    back = z0 + 2.12
    for side in (-1, 1):
        cx = x0 + 0.55 * side
        lights.quad((cx - 0.14, ground + 0.62, back), (cx + 0.14, ground + 0.62, back),
                    (cx + 0.14, ground + 0.74, back), (cx - 0.14, ground + 0.74, back))
    return [body, glass, roof, wheels, lights]


def cabin():
    dash = Mesh("dashboard", "dashboard")
    profile = [(-0.62, -0.62), (-0.52, -0.62), (-0.30, -0.66), (-0.22, -0.72), (-0.19, -0.82), (-0.185, -0.95), (-0.20, -1.15)]
    def row(y, z, bulge):
        return [(-0.75 + 1.5 * i / 24 + 0.35, y + bulge * math.exp(-((i - 7) / 3.5) ** 2), z) for i in range(25)]
    rows = [row(y, z, 0.035 if -0.9 < z < -0.65 else 0.0) for y, z in profile]
    for k in range(len(rows) - 1):
        for i in range(24):
            dash.face([rows[k][i], rows[k][i + 1], rows[k + 1][i + 1], rows[k + 1][i]],
                      [(i, k * 2), (i + 1, k * 2), (i + 1, k * 2 + 2), (i, k * 2 + 2)])
    bonnet = Mesh("bonnet", "paint_silver")
    rows = []
    for k in range(9):
        z = -1.2 - 1.1 * k / 8
        rows.append([(-0.55 + 1.8 * i / 16 - 0.0, -0.245 - 0.06 * (k / 8) ** 2 - 0.10 * ((i - 8) / 8) ** 4 * (1 + k / 8), z)
                     for i in range(17)])
    bonnet.loft(rows, False)
    trim = Mesh("pillars", "trim")
    def bar(a, b, w, d):
        """A beam of that width and depth between two points."""
        (ax, ay, az), (bx, by, bz) = a, b
        trim.quad((ax - w, ay, az + d), (ax + w, ay, az + d), (bx + w, by, bz + d), (bx - w, by, bz + d))
        trim.quad((ax + w, ay, az + d), (ax + w, ay, az - d), (bx + w, by, bz - d), (bx + w, by, bz + d))
        trim.quad((ax - w, ay, az - d), (ax - w, ay, az + d), (bx - w, by, bz + d), (bx - w, by, bz - d))
        trim.quad((ax + w, ay, az - d), (ax - w, ay, az - d), (bx - w, by, bz - d), (bx + w, by, bz - d))
    bar((-0.42, -0.25, -1.05), (-0.30, 0.32, -0.52), 0.035, 0.05)
    bar((1.12, -0.25, -1.05), (1.0, 0.32, -0.52), 0.035, 0.05)
    trim.box((-0.5, 0.30, -0.56), (1.2, 0.40, 0.6))
    trim.box((0.30, 0.13, -0.62), (0.52, 0.20, -0.58))
    screen = Mesh("windshield", "glass", True)
    screen.quad((-0.44, -0.22, -1.12), (1.14, -0.22, -1.12), (1.02, 0.31, -0.54), (-0.32, 0.31, -0.54))
    return [dash, bonnet, trim, screen]


# Materials ------------------------------------------------------------------------------------------------------------

def preview(name, inputs, textures_=()):
    """A UsdPreviewSurface; `textures_`: (input, file, output, colour space)."""
    lines = [f'def Material "{name}"', "{", f"    token outputs:surface.connect = </street/materials/{name}/surface.outputs:surface>",
             '    def Shader "surface"', "    {", '        uniform token info:id = "UsdPreviewSurface"']
    lines += [f"        {line}" for line in inputs]
    files = {}
    for target, file, output, space in textures_:
        node = files.setdefault((file, space), f"picture{len(files)}")
        kind = {"rgb": "color3f", "r": "float", "g": "float", "b": "float", "a": "float"}[output]
        kind = "normal3f" if target == "normal" else kind
        lines.append(f"        {kind} inputs:{target}.connect = </street/materials/{name}/{node}.outputs:{output}>")
    lines += ["        token outputs:surface", "    }"]
    for (file, space), node in files.items():
        lines += [f'    def Shader "{node}"', "    {", '        uniform token info:id = "UsdUVTexture"',
                  f"        asset inputs:file = @./textures/{file}@", f'        token inputs:sourceColorSpace = "{space}"',
                  '        token inputs:wrapS = "repeat"', '        token inputs:wrapT = "repeat"',
                  f"        float2 inputs:st.connect = </street/materials/{name}/st.outputs:result>"]
        if file.endswith("_normal.png"):
            lines += ["        float4 inputs:scale = (2, 2, 2, 1)", "        float4 inputs:bias = (-1, -1, -1, 0)"]
        lines += ["        float3 outputs:rgb", "        float outputs:r", "        float outputs:g",
                  "        float outputs:b", "        float outputs:a", "    }"]
    if files:
        lines += ['    def Shader "st"', "    {", '        uniform token info:id = "UsdPrimvarReader_float2"',
                  '        string inputs:varname = "st"', "        float2 outputs:result", "    }"]
    return "\n".join("        " + line for line in lines + ["}"])


def materials():
    def colour(r, g, b):
        return f"color3f inputs:diffuseColor = ({r}, {g}, {b})"
    def rough(v):
        return f"float inputs:roughness = {v}"
    out = [
        preview("asphalt", [rough(0.85)], [("diffuseColor", "asphalt.png", "rgb", "sRGB")]),
        preview("paint", [colour(0.78, 0.78, 0.75), rough(0.6)]),
        preview("concrete", [colour(0.42, 0.41, 0.39), rough(0.9)]),
        preview("paving", [rough(0.85)], [("diffuseColor", "paving.png", "rgb", "sRGB")]),
        preview("roof", [colour(0.16, 0.15, 0.15), rough(0.8)]),
        preview("bark", [colour(0.15, 0.11, 0.08), rough(0.9)]),
        preview("leaves", [rough(0.6), "float inputs:opacityThreshold = 0.5"],
                [("diffuseColor", "leaves.png", "rgb", "sRGB"), ("opacity", "leaves.png", "a", "sRGB")]),
        preview("metal", [colour(0.35, 0.36, 0.37), rough(0.4), "float inputs:metallic = 1"]),
        preview("rubber", [colour(0.03, 0.03, 0.03), rough(0.8)]),
        preview("tinted", [colour(0.02, 0.02, 0.025), rough(0.03)]),
        preview("trim", [colour(0.05, 0.05, 0.055), rough(0.7)]),
        preview("dashboard", [colour(0.04, 0.04, 0.045), rough(0.55)], [("normal", "grain_normal.png", "rgb", "raw")]),
        preview("lamp", [colour(0.8, 0.8, 0.8), "color3f inputs:emissiveColor = (9000, 7600, 5600)"]),
        preview("tail", [colour(0.3, 0.02, 0.02), "color3f inputs:emissiveColor = (2600, 90, 60)"]),
        preview("head", [colour(0.8, 0.8, 0.8), "color3f inputs:emissiveColor = (30000, 29000, 27000)"]),
    ]
    for name in ("brick", "plaster", "stone"):
        out.append(preview(name, [], [("diffuseColor", f"{name}.png", "rgb", "sRGB"),
                                      ("roughness", f"{name}_surface.png", "g", "raw")]))
    for name, rgb in (("blue", (0.03, 0.10, 0.35)), ("red", (0.45, 0.03, 0.03)), ("silver", (0.45, 0.46, 0.47))):
        out.append(preview(f"paint_{name}", [colour(*rgb), rough(0.45), "float inputs:metallic = 0.35",
                                             "float inputs:clearcoat = 1", "float inputs:clearcoatRoughness = 0.02"]))
    # A thin sheet of glass: standard surface, since a preview surface has no transmission.
    out.append("\n".join("        " + line for line in [
        'def Material "glass"', "{",
        "    token outputs:mtlx:surface.connect = </street/materials/glass/surface.outputs:out>",
        '    def Shader "surface"', "    {", '        uniform token info:id = "ND_open_pbr_surface_surfaceshader"',
        "        color3f inputs:base_color = (1, 1, 1)", "        float inputs:specular_roughness = 0",
        "        float inputs:specular_ior = 1.52", "        float inputs:transmission_weight = 1",
        "        bool inputs:geometry_thin_walled = 1", "        token outputs:out", "    }", "}"]))
    return out


def main():
    textures()
    lines = ["#usda 1.0", "(", '    defaultPrim = "street"', "    metersPerUnit = 1", '    upAxis = "Z"',
             '    doc = "Made by samples/street/make.py; CC0"', ")", "", 'def Xform "street"', "{",
             '    def Scope "materials"', "    {", *materials(), "    }"]
    lines += [mesh.usda(4) for mesh in street() + cabin()]
    with open(os.path.join(HERE, "street.usda"), "w") as out:
        out.write("\n".join(lines + ["}", ""]))


if __name__ == "__main__":
    main()
