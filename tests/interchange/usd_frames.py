"""Writes what usd-core says of tests/data/usd_frames at some times, for src/import/usd/tests/frames.rs.

usage: usd_frames.py [--check]

Needs usd-core in the Python that runs it. One line per prim and time: time, path, what, values. `world` is the matrix to
the world, rows for row vectors; `hidden` stands for prims that are not visible, which have no other lines; `points` are
those of meshes; `intensity`, `exposure`, `width`, `normalize` those of lights. With --check it compares the file that is
there instead; exit 1 if it differs.
"""

import sys
from pathlib import Path

from pxr import Usd, UsdGeom, UsdLux

FOLDER = Path(__file__).parent.parent / "data" / "usd_frames"
TIMES = [-5, 0, 2.5, 4, 5, 7.25, 8, 10, 12.5, 15, 18, 20, 27, 100]


def lines():
    version = ".".join(str(number) for number in Usd.GetVersion()[1:])
    yield f"# Made by tests/interchange/usd_frames.py with usd-core {version}; its first lines say what this is."
    stage = Usd.Stage.Open(str(FOLDER / "root.usda"))
    numbers = lambda values: " ".join(repr(float(x)) for x in values)
    for time in TIMES:
        for prim in Usd.PrimRange(stage.GetPrimAtPath("/World"), Usd.TraverseInstanceProxies()):
            path = str(prim.GetPath())[1:]
            if UsdGeom.Imageable(prim).ComputeVisibility(time) == "invisible":
                yield f"{time} {path} hidden"
                continue
            world = UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(time)
            yield f"{time} {path} world {numbers(x for row in world for x in row)}"
            if mesh := UsdGeom.Mesh(prim):
                yield f"{time} {path} points {numbers(x for point in mesh.GetPointsAttr().Get(time) for x in point)}"
            if light := UsdLux.RectLight(prim):
                for name in ("intensity", "exposure", "width", "normalize"):
                    yield f"{time} {path} {name} {float(prim.GetAttribute('inputs:' + name).Get(time))!r}"


def main():
    text, file = "\n".join(lines()) + "\n", FOLDER / "expected.txt"
    if sys.argv[1:] == ["--check"]:
        sys.exit(file.read_text().splitlines()[1:] != text.splitlines()[1:])
    file.write_text(text)


if __name__ == "__main__":
    main()
