"""USD files that usd-core opens, against what `eyebox inspect --geometry` makes of them.

usage: usd_corpus.py [--materials] EYEBOX FOLDER...

Needs usd-core and numpy in the Python that runs it. For each FOLDER: every .usd, .usda, .usdc and .usdz is opened by
usd-core. A file is valid if that raises nothing and composition finds no error. Those must open with equal triangles (the
sum of n - 2 over the polygons of all meshes that are shown, and the fixed number of each implicit shape), with equal
bounds and, with --materials, with an equal number of Material prims. What is shown: active, defined, visible, of purpose
default or render; values at the default time, else the earliest sample. One line per miss, one line of totals per folder;
exit 1 below 99 %, or if a file crashes the program, takes more than 20 s or more than 4 GiB.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

LIMIT_S = 20
LIMIT_MIB = 4096
EXTENSIONS = (".usd", ".usda", ".usdc", ".usdz")
# Triangles of the meshes that stand for implicit shapes (src/import/usd/tessellate.rs).
IMPLICIT = {"Sphere": 9024, "Cube": 12, "Cylinder": 768, "Cylinder_1": 768, "Cone": 384, "Capsule": 18432, "Capsule_1": 18432, "Plane": 2}
# How far a chord of theirs is from the curve, of the radius: a step of 360 / 96 degrees.
SAG = 1e-3


def value(attribute):
    """At the default time, else the earliest sample."""
    if not attribute:
        return None
    return attribute.Get(time_of(attribute))


def time_of(attribute):
    from pxr import Usd

    said = attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource()
    is_said = said not in (Usd.ResolveInfoSourceNone, Usd.ResolveInfoSourceFallback)
    return Usd.TimeCode.Default() if is_said else Usd.TimeCode.EarliestTime()


# A file that usd-core reads may still say what cannot be meant; it is refused with a message.
REFUSED = (
    "`upAxis` is no axis",
    "the matrix is not affine",
    "expected finite points",
    "a value of another type; expected point3f[]",
)


class Shown:
    """Counts and bounds of what a stage shows."""

    def __init__(self, stage):
        import numpy as np
        from pxr import UsdGeom

        self.np, self.stage = np, stage
        self.triangles, self.implicit, self.slack = 0, 0, 0.0
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)
        self.known = {}
        for prim in stage.GetPseudoRoot().GetChildren():
            self.walk(prim, np.eye(4), True, False)
        unit = UsdGeom.GetStageMetersPerUnit(stage)
        self.low, self.high, self.slack = self.low * unit, self.high * unit, self.slack * unit
        if UsdGeom.GetStageUpAxis(stage) == "Z":
            (x, y, z), (a, b, c) = self.low, self.high
            self.low, self.high = np.array([x, z, -b]), np.array([a, c, -y])

    def unit(self, quaternion):
        """At length 1 in f64. usd-core's own way is by the arc cosine of w, which turns the rounding of a half or float
        into angles of 1e-4 to 1e-2."""
        from pxr import Gf

        out = Gf.Quatd(quaternion)
        return out.GetNormalized() if out.GetLength() > 0 else Gf.Quatd(1)

    def matrix(self, prim):
        """Rows for row vectors; and whether what is above counts."""
        from pxr import Gf, Usd, UsdGeom

        xformable = UsdGeom.Xformable(prim)
        out = Gf.Matrix4d(1)
        if not xformable:
            return self.np.array(out), False
        order = value(xformable.GetXformOpOrderAttr())
        resets = order is not None and "!resetXformStack!" in list(order)
        for op in xformable.GetOrderedXformOps():
            time = time_of(op.GetAttr())
            if op.GetOpType() == UsdGeom.XformOp.TypeOrient and (turn := op.Get(time)) is not None:
                matrix = Gf.Matrix4d(1).SetRotate(self.unit(turn))
                out = (matrix.GetInverse() if op.IsInverseOp() else matrix) * out
            else:
                out = op.GetOpTransform(time) * out
        return self.np.array(out), resets

    def walk(self, prim, above, shown, may_be_over):
        from pxr import Sdf, Usd, UsdGeom

        if not prim.IsActive() or not prim.IsLoaded() or not (prim.GetSpecifier() == Sdf.SpecifierDef or may_be_over):
            return
        imageable = UsdGeom.Imageable(prim)
        if imageable and value(imageable.GetVisibilityAttr()) == "invisible":
            return
        if imageable and imageable.GetPurposeAttr().HasAuthoredValue():
            shown = value(imageable.GetPurposeAttr()) in ("default", "render")
        local, resets = self.matrix(prim)
        world = local if resets else local @ above
        kind = prim.GetTypeName()
        if kind == "PointInstancer":
            if shown:
                self.instancer(UsdGeom.PointInstancer(prim), world)
            return
        if shown and kind == "Mesh":
            self.mesh(UsdGeom.Mesh(prim), world)
        elif shown and kind in IMPLICIT:
            self.shape(prim, kind, world)
        for child in prim.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
            self.walk(child, world, shown, False)

    def instancer(self, instancer, world):
        from pxr import Gf, Usd

        np = self.np
        get = lambda name: value(instancer.GetPrim().GetAttribute(name)) or []
        indices, positions, scales = get("protoIndices"), get("positions"), get("scales")
        turns = get("orientationsf") or get("orientations")
        if len(positions) != len(indices) or any(len(some) not in (0, len(indices)) for some in (scales, turns)):
            return
        mask = instancer.ComputeMaskAtTime(Usd.TimeCode.Default()) or [True] * len(indices)
        prototypes = [self.stage.GetPrimAtPath(path) for path in instancer.GetPrototypesRel().GetForwardedTargets()]
        for i, index in enumerate(indices):
            if not mask[i] or not 0 <= index < len(prototypes) or not prototypes[index]:
                continue
            own = np.diag([*(scales[i] if scales else (1, 1, 1)), 1.0])
            if turns:
                own = own @ np.array(Gf.Matrix4d(1).SetRotate(self.unit(turns[i])))
            own[3, :3] = positions[i]
            self.walk(prototypes[index], own @ world, True, True)

    def grow(self, points, world):
        np = self.np
        there = points @ world[:3, :3] + world[3, :3]
        self.low, self.high = np.minimum(self.low, there.min(0)), np.maximum(self.high, there.max(0))

    def mesh(self, mesh, world):
        np = self.np
        key = mesh.GetPrim().GetPrimInPrototype().GetPath() if mesh.GetPrim().IsInstanceProxy() else mesh.GetPath()
        if key not in self.known:
            points = np.array(value(mesh.GetPointsAttr()) or np.zeros((0, 3)), np.float32)
            points = points if points.ndim == 2 and points.shape[1] == 3 else np.zeros((0, 3))
            counts = np.array(value(mesh.GetFaceVertexCountsAttr()) or [], np.int64)
            indices = np.array(value(mesh.GetFaceVertexIndicesAttr()) or [], np.int64)
            holes = np.array(value(mesh.GetHoleIndicesAttr()) or [], np.int64)
            keep = counts >= 3
            keep[holes[(holes >= 0) & (holes < len(counts))]] = False
            if len(points) and len(counts) and counts.sum() == len(indices):
                used = np.unique(indices[np.repeat(keep, counts)])
                self.known[key] = int((counts[keep] - 2).sum()), points[used].astype(np.float64)
            else:
                self.known[key] = 0, np.zeros((0, 3))
        triangles, points = self.known[key]
        self.triangles += triangles
        if len(points):
            self.grow(points, world)

    def shape(self, prim, kind, world):
        np = self.np
        get = lambda name: value(prim.GetAttribute(name))
        h = {"Cube": lambda: get("size") / 2, "Sphere": lambda: 0.0, "Plane": lambda: 0.0}.get(kind, lambda: get("height") / 2)()
        low, high = [get("radiusBottom"), get("radiusTop")] if kind.endswith("_1") else [get("radius")] * 2
        axes = {"X": (1, 2, 0), "Y": (2, 0, 1), "Z": (0, 1, 2)}
        u, v, w = (np.eye(3)[axis] for axis in axes[get("axis") or "Z"])
        if kind == "Cube":
            points = np.array([[x, y, z] for x in (-h, h) for y in (-h, h) for z in (-h, h)])
        elif kind == "Plane":
            x, y, z = {"X": ("", "length", "width"), "Y": ("width", "", "length"), "Z": ("width", "length", "")}[get("axis")]
            spans = [[-get(n) / 2, get(n) / 2] if n else [0.0] for n in (x, y, z)]
            points = np.array([[a, b, c] for a in spans[0] for b in spans[1] for c in spans[2]])
        else:
            turn = np.linspace(0, 2 * np.pi, 721)[:, None]
            ring = np.cos(turn) * u + np.sin(turn) * v
            if kind in ("Cylinder", "Cylinder_1", "Cone"):
                points = np.concatenate([ring * low - h * w, (h * w)[None] if kind == "Cone" else ring * high + h * w])
            else:
                tilt = np.linspace(-np.pi / 2, np.pi / 2, 181)[:, None, None]
                ball = (np.cos(tilt) * ring + np.sin(tilt) * w).reshape(-1, 3)
                points = np.concatenate([ball * low - h * w, ball * low + h * w])
            self.slack = max(self.slack, SAG * max(low, high) * np.abs(world[:3, :3]).max() * 3)
        self.triangles += IMPLICIT[kind]
        self.implicit += 1
        self.grow(points, world)


def materials(stage):
    from pxr import Usd

    ranges = [Usd.PrimRange(stage.GetPseudoRoot())] + [Usd.PrimRange(prototype) for prototype in stage.GetPrototypes()]
    return sum(prim.GetTypeName() == "Material" for prims in ranges for prim in prims)


def describe(files):
    """One JSON object per file on standard output."""
    from pxr import Tf, Usd

    for file in files:
        print(json.dumps({"begin": file}), flush=True)
        out = {"file": file}
        try:
            stage = Usd.Stage.Open(file)
            out["composition"] = [str(error) for error in stage.GetCompositionErrors()][:3]
            shown = Shown(stage)
            bounds = [shown.low.tolist(), shown.high.tolist()] if shown.low[0] < float("inf") else None
            out.update(triangles=shown.triangles, implicit=shown.implicit, slack=shown.slack, bounds=bounds, materials=materials(stage))
        except Tf.ErrorException as error:
            out["error"] = str(error).strip().splitlines()[0][:200]
        except Exception as error:
            out["failed"] = f"{type(error).__name__}: {error}"[:300]
        print(json.dumps(out), flush=True)


def usd_core(files):
    """What usd-core says, by file; a process at a time, a new one after a crash or a hang."""
    out, left = {}, list(files)
    while left:
        batch = left[:50]
        try:
            ran = subprocess.run([sys.executable, __file__, "--describe", *batch], capture_output=True, text=True, timeout=10 * LIMIT_S)
            text = ran.stdout
        except subprocess.TimeoutExpired as expired:
            text = (expired.stdout or b"").decode()
        records = [json.loads(line) for line in text.splitlines() if line.startswith("{") and line.endswith("}")]
        begun = [record["begin"] for record in records if "begin" in record]
        out.update({record["file"]: record for record in records if "file" in record})
        for file in begun or batch[:1]:
            out.setdefault(file, {"file": file, "error": "usd-core crashes or hangs"})
        left = [file for file in left if file not in out]
    return out


def eyebox(program, file):
    """(exit status, facts, first line of errors, seconds, MiB)"""
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as wrong:
        child = subprocess.Popen([program, "inspect", file, "--geometry", "--format", "json"], stdout=said, stderr=wrong)
        signal.signal(signal.SIGALRM, lambda *_: child.kill())
        signal.alarm(LIMIT_S)
        _, status, used = os.wait4(child.pid, 0)
        signal.alarm(0)
        child.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0), wrong.seek(0)
        facts = json.loads(said.read()) if child.returncode == 0 else None
        return child.returncode, facts, wrong.read().decode(errors="replace").strip()[:300], used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def differences(facts, theirs, with_materials):
    totals, wrong = facts["totals"], []
    if totals["triangles"] != theirs["triangles"]:
        wrong.append(f"triangles {totals['triangles']}, usd-core says {theirs['triangles']}")
    if with_materials and totals["materials"] != theirs["materials"]:
        wrong.append(f"materials {totals['materials']}, usd-core says {theirs['materials']}")
    ours, there = totals["bounds_m"], theirs["bounds"]
    if ours is None or there is None:
        if (ours is None) != (there is None):
            wrong.append(f"bounds {ours}, usd-core says {there}")
    else:
        scale = max(abs(x) for corner in there for x in corner)
        apart = max(abs(a - b) for a, b in zip(ours["low"] + ours["high"], there[0] + there[1]))
        if not apart <= 1e-12 * scale + theirs["slack"]:
            wrong.append(f"bounds {ours['low']} {ours['high']}, usd-core says {there[0]} {there[1]}")
    return "; ".join(wrong)


def main():
    arguments = sys.argv[1:]
    if arguments[:1] == ["--describe"]:
        return describe(arguments[1:])
    with_materials = "--materials" in arguments
    program, *folders = [argument for argument in arguments if argument != "--materials"]
    good = True
    for folder in folders:
        files = sorted(str(f) for f in Path(folder).rglob("*") if f.suffix.lower() in EXTENSIONS and f.is_file())
        theirs = usd_core(files)
        refused, readable, valid, opened, equal, equal_all, bad = 0, 0, 0, 0, 0, 0, 0
        slowest, largest = (0.0, ""), (0.0, "")
        for file in files:
            status, facts, said, seconds, mib = eyebox(program, file)
            slowest, largest = max(slowest, (seconds, file)), max(largest, (mib, file))
            if status not in (0, 2) or mib > LIMIT_MIB:
                bad += 1
                print(f"BAD {file}: exit {status}, {seconds:.1f} s, {mib:.0f} MiB {said}")
            record = theirs[file]
            if "failed" in record:
                print(f"SCRIPT {file}: {record['failed']}")
            if "error" in record or "failed" in record:
                continue
            if status == 2 and any(text in said for text in REFUSED):
                refused += 1
                print(f"REFUSED {file}: {said}")
                continue
            readable += 1
            is_valid = not record["composition"]
            valid += is_valid
            wrong = differences(facts, record, with_materials) if status == 0 else said
            opened += status == 0
            equal_all += not wrong and status == 0
            if wrong or status != 0:
                print(f"{'MISS' if is_valid else 'INVALID'} {file}: {wrong}")
            else:
                equal += is_valid
        share = equal / max(valid, 1)
        print(
            f"{folder}: {len(files)} files, usd-core opens {readable + refused}, {refused} of them rightly refused; eyebox opens {opened} of the {readable}, {equal_all} equal; valid {valid}, "
            f"{equal} equal ({100 * share:.2f} %); slowest {slowest[0]:.2f} s {slowest[1]}, largest {largest[0]:.0f} MiB {largest[1]}; {bad} bad"
        )
        good &= share >= 0.99 and bad == 0
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
