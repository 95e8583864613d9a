"""Import of large .usdc files against usd-core's raw read of the same arrays.

usage: usd_speed.py BENCH SCRATCH

BENCH is the program that `cargo bench --ignore-rust-version --bench import --no-run` names. Writes into SCRATCH a
paraboloid of two million triangles with vertex and with faceVarying normals, and 10 000 instances of one prototype;
prints, mean and best of ten, what Usd.Stage.Open with Get of points, counts, indices and normals takes of the processor, then
what BENCH measures.
Needs usd-core and numpy.
"""

import os
import subprocess
import sys
import time

import numpy as np
from pxr import Usd, UsdGeom, Vt


def grid(file, interpolation, side=1000):
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-0.5, 0.5, side + 1)] * 2))
    points = np.stack([x, y, (x * x + y * y) / 2], 1)
    normals = np.stack([-x, -y, np.ones_like(x)], 1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    a = (np.arange(side)[:, None] * (side + 1) + np.arange(side)[None]).ravel()
    corners = np.stack([a, a + 1, a + side + 2, a, a + side + 2, a + side + 1], 1).ravel()
    stage = Usd.Stage.CreateNew(file)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    mesh = UsdGeom.Mesh.Define(stage, "/Grid")
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(2 * side * side, 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.astype(np.int32)))
    wanted = normals if interpolation == "vertex" else normals[corners]
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(wanted.astype(np.float32)))
    mesh.SetNormalsInterpolation(interpolation)
    stage.Save()


def instances(file, count=10000):
    stage = Usd.Stage.CreateNew(file)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prototype = stage.CreateClassPrim("/Prototype")
    cube = UsdGeom.Mesh.Define(stage, "/Prototype/Cube")
    cube.CreatePointsAttr([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    cube.CreateFaceVertexCountsAttr([4] * 6)
    cube.CreateFaceVertexIndicesAttr([0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3])
    cube.CreateSubdivisionSchemeAttr("none")
    for i in range(count):
        instance = UsdGeom.Xform.Define(stage, f"/I{i}")
        instance.GetPrim().GetInherits().AddInherit(prototype.GetPath())
        instance.GetPrim().SetInstanceable(True)
        instance.AddTranslateOp().Set((2.0 * (i % 100), 2.0 * (i // 100), 0.0))
    stage.Save()


def raw(file):
    stage = Usd.Stage.Open(file)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            for attribute in (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetNormalsAttr()):
                # A mapped array is read when it is touched.
                got = attribute.Get()
                got is None or np.array(got, copy=True)


def main():
    bench, scratch = sys.argv[1:]
    os.makedirs(scratch, exist_ok=True)
    for name, make in (("vertex", grid), ("faceVarying", grid), ("instances", instances)):
        file = os.path.join(scratch, f"{name}.usdc")
        if not os.path.exists(file):
            make(file, name) if make is grid else make(file)
        spent = []
        for _ in range(10):
            start = time.process_time()
            raw(file)
            spent.append(time.process_time() - start)
        mean, best = sum(spent) / len(spent) * 1e3, min(spent) * 1e3
        print(f"usd-core {name}: {mean:.1f} ms of processor time, {best:.1f} at best", flush=True)
        subprocess.run([bench, file], check=True)


if __name__ == "__main__":
    main()
