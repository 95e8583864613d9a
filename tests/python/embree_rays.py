#!/usr/bin/env python3
"""embree_rays.py FILE.rays ... -- how many incoherent rays a second Embree traces, to compare with eyebox.

The files are those that `cargo bench --ignore-rust-version --bench rays -- FOLDER` writes: three little-endian uint32
counts of vertices, triangles and rays, then float32 vertices, uint32 triangles, float32 rays as origin and direction.
Closest hit, one ray at a time (rtcIntersect1), one thread, best of five rounds in CPU seconds of the thread.
Needs: numpy, embreex (which brings Embree 4), both from PyPI.
"""
import sys
import time

import numpy
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

ROUNDS = 5


def read(path):
    """-> (float32 vertices (n, 3), uint32 triangles (m, 3), float32 rays (k, 6))"""
    data = numpy.fromfile(path, dtype="<u4")
    vertices, triangles, rays = (int(count) for count in data[:3])
    ends = 3 + numpy.cumsum([3 * vertices, 3 * triangles, 6 * rays])
    return (
        data[3 : ends[0]].view("<f4").reshape(-1, 3),
        data[ends[0] : ends[1]].reshape(-1, 3),
        data[ends[1] : ends[2]].view("<f4").reshape(-1, 6),
    )


for path in sys.argv[1:]:
    vertices, triangles, rays = read(path)
    scene = rtcore_scene.EmbreeScene()
    mesh = TriangleMesh(scene, vertices[triangles])
    origins = numpy.ascontiguousarray(rays[:, :3])
    directions = numpy.ascontiguousarray(rays[:, 3:])
    scene.run(origins[:1], directions[:1])  # builds
    best, found = float("inf"), None
    for _ in range(ROUNDS):
        start = time.thread_time()
        found = scene.run(origins, directions, query="INTERSECT")
        best = min(best, time.thread_time() - start)
    print(
        f"{path}: {len(triangles)} triangles, {len(rays) / best * 1e-6:.3f} Mrays/s, "
        f"{best / len(rays) * 1e9:.0f} ns a ray; {numpy.count_nonzero(found >= 0)} hits"
    )
