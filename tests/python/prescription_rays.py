#!/usr/bin/env python3
"""Rays through lens files by rayoptics, which is not ours, into tests/data/prescriptions/rays.csv:

    pip install rayoptics==0.9.8
    python3 tests/python/prescription_rays.py tests/data/prescriptions

Points where rays of 550 nm meet the surfaces, in the axes of surface 1, and their directions behind each.
"""

import sys
from pathlib import Path

import numpy as np
import rayoptics.environment as ro
from rayoptics.raytr import raytrace


def main(folder):
    with open(folder / "rays.csv", "w") as out:
        out.write("# Made by tests/python/prescription_rays.py: rayoptics 0.9.8. file, ray, surface, point, direction behind it\n")
        for file in sorted([*folder.glob("*.zmx"), *folder.glob("*.seq")]):
            model, _ = ro.open_model(str(file), info=True)
            seq = model.seq_model
            frames = seq.compute_global_coords(1)
            ray = 0
            for x, y in [(0, 0), (2, 1), (-3, 0.5), (0.3, -3.5)]:
                for slope in [(0, 0), (0.03, -0.05)]:
                    start = np.array([x, y, 0.0])
                    way = np.array([slope[0], slope[1], 1.0])
                    way /= np.linalg.norm(way)
                    # The path without the object: from surface 1 on, where the ray starts.
                    path = seq.path(wl=550.0, start=1)
                    hits = raytrace.trace_raw(path, start, way, 550.0)[0]
                    for surface, hit in enumerate(hits, 1):
                        turn, at = frames[surface]
                        point, direction = turn @ hit[0] + at, turn @ hit[1]
                        numbers = ",".join(repr(float(v)) for v in [*point, *direction])
                        out.write(f"{file.name},{ray},{surface},{numbers}\n")
                    ray += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
