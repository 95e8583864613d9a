#!/usr/bin/env python3
"""Writes the geometry of the peers' scenes: a1/a1.glb, a2/a2.glb and b/b.glb beside this file.

Python 3 standard library only; the same bytes on every run. Lengths in millimetres, in the coordinates in which the
scenes are described (README.md). One glTF node and mesh per object, one primitive per face. What the faces do with light
and the exact spheres are said in the sidecars (*.optics.toml), which are written by hand.
"""

import json
import math
import struct
from pathlib import Path

SEGMENTS = 144  # around the lens and the frame; divisible by 6
RINGS = SEGMENTS // 6  # of a lens cap


def f32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return [x / length for x in a]


# A face is (positions, normals, triangles, material). Triangles turn counter-clockwise seen from where normals point.


def quad(corners, material):
    """A flat quadrangle; its normal follows from the order of its corners."""
    normal = unit(cross(sub(corners[1], corners[0]), sub(corners[3], corners[0])))
    return corners, [normal] * 4, [(0, 1, 2), (0, 2, 3)], material


def ball(centre, radius, material, stacks=32, slices=64):
    """A closed sphere with its poles along y, away from the scenes' main axis; no seam, no triangle without area."""
    normals = [[0.0, 1.0, 0.0]]
    for i in range(1, stacks):
        ring, y = math.sin(math.pi * i / stacks), math.cos(math.pi * i / stacks)
        for j in range(slices):
            angle = 2 * math.pi * j / slices
            normals.append([ring * math.sin(angle), y, ring * math.cos(angle)])
    normals.append([0.0, -1.0, 0.0])
    at = lambda i, j: 1 + (i - 1) * slices + j % slices
    last = len(normals) - 1
    triangles = []
    for j in range(slices):
        triangles.append((0, at(1, j), at(1, j + 1)))
        for i in range(1, stacks - 1):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, b, c), (a, c, d)]
        triangles.append((last, at(stacks - 1, j + 1), at(stacks - 1, j)))
    positions = [[c + radius * n for c, n in zip(centre, normal)] for normal in normals]
    return positions, normals, triangles, material


def circle(radius, z, count):
    angles = [2 * math.pi * j / count for j in range(count)]
    return [[radius * math.cos(a), radius * math.sin(a), z] for a in angles]


def cap(centre_z, radius, semi_diameter, side, material):
    """A spherical cap about the z axis on the side (+1, -1) of its centre. Ring k of the mesh has 6k vertices, so the
    triangles are nearly equilateral up to the rim."""
    positions = [[0.0, 0.0, centre_z + side * radius]]
    for k in range(1, RINGS + 1):
        r = semi_diameter * k / RINGS
        positions += circle(r, centre_z + side * math.sqrt(radius**2 - r**2), 6 * k)
    normals = [unit(sub(p, [0.0, 0.0, centre_z])) for p in positions]
    at = lambda k, j: 0 if k == 0 else 1 + 3 * k * (k - 1) + j % (6 * k)
    triangles = []
    for k in range(1, RINGS + 1):
        for sector in range(6):
            for i in range(k):
                outer, inner = sector * k + i, sector * (k - 1) + i
                triangles.append((at(k, outer), at(k, outer + 1), at(k - 1, inner)))
                if i + 1 < k:
                    triangles.append((at(k, outer + 1), at(k - 1, inner + 1), at(k - 1, inner)))
    if side < 0:
        triangles = [(a, c, b) for a, b, c in triangles]
    return positions, normals, triangles, material


def band(lower, upper, normals, material):
    """Between two circles that run counter-clockwise seen from +z: outside a cylinder if `lower` lies at smaller z, seen
    from -z if `lower` is the smaller circle in the same plane."""
    n = len(lower)
    triangles = []
    for j in range(n):
        a, b, c, d = j, (j + 1) % n, n + (j + 1) % n, n + j
        triangles += [(a, b, c), (a, c, d)]
    return lower + upper, normals, triangles, material


def biconvex(front_z, thickness, radius, semi_diameter, material, edge):
    """Faces 0 front cap (towards -z), 1 rim, 2 back cap; the caps meet the rim vertex by vertex."""
    front_centre, back_centre = front_z + radius, front_z + thickness - radius
    height = math.sqrt(radius**2 - semi_diameter**2)
    outward = [unit([x, y, 0.0]) for x, y, _ in circle(1.0, 0.0, SEGMENTS)]
    lower = circle(semi_diameter, front_centre - height, SEGMENTS)
    upper = circle(semi_diameter, back_centre + height, SEGMENTS)
    return [
        cap(front_centre, radius, semi_diameter, -1, material),
        band(lower, upper, outward * 2, edge),
        cap(back_centre, radius, semi_diameter, +1, material),
    ]


def annulus(z, inner, outer, material):
    """A ring that faces -z."""
    return band(circle(inner, z, SEGMENTS), circle(outer, z, SEGMENTS), [[0.0, 0.0, -1.0]] * (2 * SEGMENTS), material)


LED = ("led", [quad([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]], "led")])
A1 = [
    LED,
    ("screen", [quad([[-20, -20, 40], [-20, 20, 40], [20, 20, 40], [20, -20, 40]], "white50")]),
    ("floor", [quad([[-20, -20, 0], [-20, -20, 40], [20, -20, 40], [20, -20, 0]], "white50")]),
    ("ball1", [ball([0, 0, 12], 3, "glass12")]),
]
A2 = A1 + [("ball2", [ball([12.672679, 4.082886, 19.723714], 6, "glass15")])]
B = [
    LED,
    ("lens", biconvex(41, 8, 30, 12, "glass15", "black")),
    ("frame", [annulus(53, 11.5, 60, "black")]),
] + [
    # The corners run so that the normal is -z, towards the LED, as the frame's.
    (f"bar{i}", [quad([[x, -12, 53], [x, 12, 53], [x + 2, 12, 53], [x + 2, -12, 53]], "black")])
    for i, x in enumerate((-9, -5, -1, 3, 7))
]


def glb(objects):
    """The bytes of a binary glTF 2.0 file."""
    data = bytearray()
    views, accessors, materials, meshes = [], [], [], []

    def accessor(values, code, component, kind, target, **bounds):
        data.extend(bytes(-len(data) % 4))
        packed = struct.pack(f"<{len(values)}{code}", *values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed), "target": target})
        data.extend(packed)
        count = len(values) // (3 if kind == "VEC3" else 1)
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind, **bounds}
        )
        return len(accessors) - 1

    for name, faces in objects:
        primitives = []
        for positions, normals, triangles, material in faces:
            if material not in materials:
                materials.append(material)
            columns = [[f32(p[k]) for p in positions] for k in range(3)]
            bounds = {"min": [min(c) for c in columns], "max": [max(c) for c in columns]}
            flat = lambda rows: [x for row in rows for x in row]
            attributes = {
                "POSITION": accessor(flat(positions), "f", 5126, "VEC3", 34962, **bounds),
                "NORMAL": accessor(flat(normals), "f", 5126, "VEC3", 34962),
            }
            indices = accessor(flat(triangles), "H", 5123, "SCALAR", 34963)
            primitives.append({"attributes": attributes, "indices": indices, "material": materials.index(material)})
        meshes.append({"name": name, "primitives": primitives})
    document = {
        "asset": {"version": "2.0", "generator": "samples/peers/make.py"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(objects)))}],
        "nodes": [{"name": name, "mesh": i} for i, (name, _) in enumerate(objects)],
        "meshes": meshes,
        "materials": [{"name": name} for name in materials],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data.extend(bytes(-len(data) % 4))
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


if __name__ == "__main__":
    for name, objects in (("a1", A1), ("a2", A2), ("b", B)):
        (Path(__file__).parent / name / f"{name}.glb").write_bytes(glb(objects))
