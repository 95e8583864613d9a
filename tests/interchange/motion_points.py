"""What `convert` writes of motion, against what a frame of the same asset is.

usage: motion_points.py EYEBOX SCRATCH ASSET...

Needs numpy and usd-core. Each asset is written as USD in motion, as glTF from that, and as USD again. At five whole frames,
usd-core (UsdGeom, UsdSkel: joints, blend shapes, time samples) gives the world points of all meshes of the first and the
last of them; `eyebox convert --frame` gives those of the asset at that frame, which is what a picture shows. Per asset it
prints the largest distance as a share of the asset's size, for both. Vertices are told apart by where they are: polygons that
bend are cut along another diagonal at times, so that each point of one is looked for among those of the other.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel, Vt


def skinned(cache, prim, points, time):
    """The points as joints and blend shapes bend them, and the prim in whose axes they are."""
    query = cache.GetSkinningQuery(prim)
    if not query:
        return points, prim
    skeleton = UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
    bones = cache.GetSkelQuery(skeleton)
    if query.HasBlendShapes() and bones.GetAnimQuery():
        shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        weights = bones.GetAnimQuery().ComputeBlendShapeWeights(time)
        mapper = query.GetBlendShapeMapper()
        weights = mapper.Remap(weights) if mapper else weights
        sub, blend, own = shapes.ComputeSubShapeWeights(weights)
        offsets = shapes.ComputeBlendShapePointIndices(), shapes.ComputeSubShapePointOffsets()
        shapes.ComputeDeformedPoints(sub, blend, own, *offsets, points)
    if not query.HasJointInfluences():
        return points, prim
    query.ComputeSkinnedPoints(bones.ComputeSkinningTransforms(time), points, time)
    return points, skeleton.GetPrim()


def world(file, code):
    """World points of each mesh in metres, +y up."""
    stage = Usd.Stage.Open(str(file))
    time = Usd.TimeCode.Default() if code is None else Usd.TimeCode(code)
    cache, frames = UsdSkel.Cache(), UsdGeom.XformCache(time)
    prims = list(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    for prim in prims:
        if prim.IsA(UsdSkel.Root):
            cache.Populate(UsdSkel.Root(prim), Usd.TraverseInstanceProxies())
    out = []
    for prim in prims:
        points = UsdGeom.Mesh(prim).GetPointsAttr().Get(time) if prim.IsA(UsdGeom.Mesh) else None
        if points is None or len(points) == 0:
            continue
        points, holder = skinned(cache, prim, Vt.Vec3fArray(points), time)
        matrix = np.array(frames.GetLocalToWorldTransform(holder))
        points = np.c_[np.array(points, float), np.ones(len(points))].dot(matrix)[:, :3]
        points *= UsdGeom.GetStageMetersPerUnit(stage)
        out.append(points[:, [0, 2, 1]] * [1, 1, -1] if UsdGeom.GetStageUpAxis(stage) == "Z" else points)
    return np.concatenate(out) if out else np.zeros((0, 3))


def apart(a, b):
    """The largest distance from a point of one to the nearest of the other, as a share of the size."""
    if len(a) == 0 or len(b) == 0:
        return 0.0 if len(a) == len(b) else np.inf
    size = max(np.ptp(b, axis=0).max(), np.abs(b).max(), 1e-12)
    near = lambda p, q: max(np.sqrt(((q - x) ** 2).sum(1).min()) for x in p)
    return max(near(a, b), near(b, a)) / size


def main():
    eyebox, scratch = sys.argv[1], Path(sys.argv[2])
    worst = 0.0
    for asset in map(Path, sys.argv[3:]):
        there, back, again, still = (scratch / f"{asset.stem}.{end}" for end in ("usdc", "glb", "again.usdc", "still.usdc"))
        convert = lambda *args: subprocess.run([eyebox, "convert", *map(str, args)], check=True, capture_output=True)
        for pair in ((asset, there), (there, back), (back, again)):
            convert(*pair)
        stage = Usd.Stage.Open(str(there))
        first, last = stage.GetStartTimeCode(), stage.GetEndTimeCode()
        # glTF counts seconds from 0 on: frames before it start there, 24 of them a second.
        code = lambda frame: (frame - min(first, 0)) / stage.GetTimeCodesPerSecond() * 24
        found = [0.0, 0.0]
        for frame in sorted(set(np.linspace(np.ceil(first), np.floor(last), 5).round())):
            convert(asset, still, "--frame", frame)
            wanted = world(still, None)
            for way, points in enumerate((world(there, frame), world(again, code(frame)))):
                found[way] = max(found[way], apart(points, wanted))
        print(f"{asset.name}: frames {first} to {last}, USD {found[0]:.1e}, by glTF {found[1]:.1e}", flush=True)
        worst = max(worst, *found)
    sys.exit(int(worst > 1e-5))


main()
