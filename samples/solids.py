"""Faces, solids and binary glTF for the scripts that make the small samples. Python's standard library alone; the same
bytes on every run.

A face is (positions, normals, triangles); triangles turn counter-clockwise as seen from where the normals point. A part is
(name, frame, faces): its faces in its own axes, one glTF node, mesh and frame each, one primitive per face. The exact
surfaces are said in the sidecars: a mesh only says where a surface ends.
"""

import json
import math
import struct
import zlib
from pathlib import Path


def add(a, b, scale=1.0):
    return [x + scale * y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def mirrored(direction, normal):
    return add(direction, normal, -2.0 * dot(direction, normal))


class Frame:
    """Axes of a part: its origin, its z, and an x that is laid at right angles to it."""

    def __init__(self, origin=(0.0, 0.0, 0.0), z=(0.0, 0.0, 1.0), x=(1.0, 0.0, 0.0)):
        self.origin, self.z = list(origin), unit(z)
        self.x = unit(add(x, self.z, -dot(x, self.z)))
        self.y = cross(self.z, self.x)

    def matrix(self):
        """As glTF has it, column by column."""
        return [*self.x, 0.0, *self.y, 0.0, *self.z, 0.0, *self.origin, 1.0]


def polygon(*corners):
    """A flat convex polygon that faces where its corners turn counter-clockwise."""
    corners = [list(map(float, corner)) for corner in corners]
    normal = unit(cross(add(corners[1], corners[0], -1.0), add(corners[2], corners[0], -1.0)))
    return corners, [normal] * len(corners), [(0, i, i + 1) for i in range(1, len(corners) - 1)]


def rectangle(half_x, half_y, z=0.0):
    """Faces +z."""
    a, b = half_x, half_y
    return polygon([-a, -b, z], [a, -b, z], [a, b, z], [-a, b, z])


def turned(face):
    """The same from its other side."""
    positions, normals, triangles = face
    return positions, [[-x for x in normal] for normal in normals], [(a, c, b) for a, b, c in triangles]


def prism(outline, half_y):
    """A solid of this outline of (x, z), counter-clockwise as seen from -y. Faces: one per side, in their order, then the
    ends at -y and +y. A point on a straight line between its neighbours parts a side into two faces."""
    n = len(outline)
    corner = lambda i, y: [outline[i % n][0], y, outline[i % n][1]]
    sides = [
        polygon(corner(i, half_y), corner(i + 1, half_y), corner(i + 1, -half_y), corner(i, -half_y)) for i in range(n)
    ]
    # About their middles, since there is no triangle between three points on a line.
    middle = [sum(p[k] for p in outline) / n for k in (0, 1)]
    ends = []
    for y, order in ((-half_y, [(i, (i + 1) % n) for i in range(n)]), (half_y, [((i + 1) % n, i) for i in range(n)])):
        positions = [corner(i, y) for i in range(n)] + [[middle[0], y, middle[1]]]
        ends.append((positions, [[0.0, math.copysign(1.0, y), 0.0]] * (n + 1), [(n, a, b) for a, b in order]))
    return [*sides, *ends]


def box(half_x, half_y, low, high):
    """Faces: 0 low, 1 +x, 2 high, 3 -x, 4 -y, 5 +y."""
    return prism([(-half_x, low), (half_x, low), (half_x, high), (-half_x, high)], half_y)


def height_field(sag, half_x, half_y, columns, rows):
    """A surface z = sag(x, y) over a rectangle, facing +z. Its normals are those of its slopes, by differences."""
    step = 1e-4 * max(half_x, half_y)
    positions, normals, triangles = [], [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            x, y = half_x * (2 * i / columns - 1), half_y * (2 * j / rows - 1)
            positions.append([x, y, sag(x, y)])
            slope = [(sag(x + dx, y + dy) - sag(x - dx, y - dy)) / (2 * step) for dx, dy in ((step, 0), (0, step))]
            normals.append(unit([-slope[0], -slope[1], 1.0]))
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            triangles += [(a, b, c), (a, c, d)]
    return positions, normals, triangles


def cap(sag, radius, rings=8, sectors=48):
    """A surface of revolution z = sag(r) up to a rim, facing +z."""
    step = 1e-5 * radius
    positions, normals, triangles = [[0.0, 0.0, sag(0.0)]], [[0.0, 0.0, 1.0]], []
    for k in range(1, rings + 1):
        r = radius * k / rings
        slope = (sag(r) - sag(r - step)) / step
        for j in range(sectors):
            angle = 2 * math.pi * j / sectors
            c, s = math.cos(angle), math.sin(angle)
            positions.append([r * c, r * s, sag(r)])
            normals.append(unit([-slope * c, -slope * s, 1.0]))
    at = lambda k, j: 0 if k == 0 else 1 + (k - 1) * sectors + j % sectors
    for j in range(sectors):
        triangles.append((0, at(1, j), at(1, j + 1)))
        for k in range(1, rings):
            a, b, c, d = at(k, j), at(k + 1, j), at(k + 1, j + 1), at(k, j + 1)
            triangles += [(a, b, c), (a, c, d)]
    return positions, normals, triangles


def sheet(low, high):
    """A closed solid between two faces that look along +z and have the same rows of points, `low` under `high`. Faces: the
    lower one, the upper one, the rim."""
    used = {}
    for a, b, c in low[2]:
        for edge in ((a, b), (b, c), (c, a)):
            used[edge] = True
    rim = [edge for edge in used if (edge[1], edge[0]) not in used]
    positions, normals, triangles = [], [], []
    for a, b in rim:
        side = polygon(low[0][a], low[0][b], high[0][b], high[0][a])
        triangles += [tuple(len(positions) + i for i in triangle) for triangle in side[2]]
        positions += side[0]
        normals += side[1]
    return [turned(low), high, (positions, normals, triangles)]


def lens(front, back, radius):
    """A solid of revolution between z = front(r), which looks to -z, and z = back(r). Faces: front, back, rim."""
    return sheet(cap(front, radius), cap(back, radius))


def conic(radius, constant=0.0, vertex=0.0):
    """Heights of a conic of revolution."""
    return lambda r: vertex + r * r / radius / (1.0 + math.sqrt(1.0 - (1.0 + constant) * (r / radius) ** 2))


def collimator(x, flat, focal_length, index, half_picture, radius=7.0, thickness=3.0):
    """A lens that looks along +z with its flat side at z = `flat`, and a display in its focus: parts LENS and DISPLAY. Its other
    side is a hyperboloid of conic constant -index², radius focal_length·(index - 1) about its vertex, the origin of its
    axes: the display's middle is seen at infinity without any aberration (Hecht, Optics, section 5.2.1)."""
    vertex = flat - thickness
    front = conic(focal_length * (index - 1.0), -index * index)
    return [
        ("LENS", Frame([x, 0.0, vertex]), lens(front, lambda r: thickness, radius)),
        ("DISPLAY", Frame([x, 0.0, vertex - focal_length]), [rectangle(*half_picture)]),
    ]


# Seven segments: (x0, y0, x1, y1) of a digit that is 1 wide and 2 high, and which of them each digit has.
SEGMENTS = [(0, 2, 1, 2), (1, 1, 1, 2), (1, 0, 1, 1), (0, 0, 1, 0), (0, 0, 0, 1), (0, 1, 0, 2), (0, 1, 1, 1)]
DIGITS = ["abcdef", "bc", "abged", "abgcd", "fgbc", "afgcd", "afgedc", "abc", "abcdefg", "abcdfg"]


def digits(text, x, y, height, thickness):
    """Whether a point (u, v) lies in these digits, whose lower left corner is (x, y): a function of u and v."""
    scale = height / 2.0
    bars = []
    for place, digit in enumerate(text):
        for name in DIGITS[int(digit)]:
            x0, y0, x1, y1 = SEGMENTS["abcdefg".index(name)]
            left = x + 1.6 * scale * place
            bars.append((left + scale * x0, y + scale * y0, left + scale * x1, y + scale * y1))
    half = thickness / 2.0
    return lambda u, v: any(a - half <= u <= c + half and b - half <= v <= d + half for a, b, c, d in bars)


def sign(text):
    """A number in a frame, with the middle marked: a picture of 30 by 17, as `write_png` takes it."""
    number = digits(text, -0.34, -0.12, 0.24, 0.05)

    def picture(u, v):
        frame = abs(u) > 0.98 or abs(v) > 17 / 30 - 0.02
        mark = min(abs(u), abs(v)) < 0.01 and max(abs(u), abs(v)) > 0.4
        return float(frame or mark or number(u, v))

    return picture


def write_png(path, width, height, pixel):
    """pixel(u, v) with u to the right and v up, from -1 to 1 over the width and by the same scale over the height, gives a
    number from 0 to 1, or three for a picture in colour; linear values in 8 bits."""
    first = pixel(0.0, 0.0)
    colour = isinstance(first, (tuple, list))
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            value = pixel((2 * x + 1) / width - 1, (height - 2 * y - 1) / width)
            rows.extend(max(0, min(255, int(255 * v + 0.5))) for v in (value if colour else [value]))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2 if colour else 0, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b"")
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def write_glb(path, parts, generator):
    data, views, accessors, meshes, nodes = bytearray(), [], [], [], []

    def accessor(rows, code, component, kind, target):
        flat = [x for row in rows for x in row]
        data.extend(bytes(-len(data) % 4))
        packed = struct.pack(f"<{len(flat)}{code}", *flat)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed), "target": target})
        data.extend(packed)
        new = {"bufferView": len(views) - 1, "componentType": component, "count": len(flat), "type": kind}
        if kind == "VEC3":
            kept = list(struct.iter_unpack("<3f", packed))
            columns = list(zip(*kept))
            new.update({"count": len(kept), "min": [min(c) for c in columns], "max": [max(c) for c in columns]})
        accessors.append(new)
        return len(accessors) - 1

    for name, frame, faces in parts:
        primitives = []
        for positions, normals, triangles in faces:
            attributes = {
                "POSITION": accessor(positions, "f", 5126, "VEC3", 34962),
                "NORMAL": accessor(normals, "f", 5126, "VEC3", 34962),
            }
            indices = accessor(triangles, "H", 5123, "SCALAR", 34963)
            primitives.append({"attributes": attributes, "indices": indices})
        meshes.append({"name": name, "primitives": primitives})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "matrix": frame.matrix()})
    document = {
        "asset": {"version": "2.0", "generator": generator},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data.extend(bytes(-len(data) % 4))
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
