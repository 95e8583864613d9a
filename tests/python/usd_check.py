#!/usr/bin/env python3
"""usd_check.py EYEBOX [SAMPLES] -- what Pixar's USD makes of the USD that eyebox writes.

EYEBOX is the program, SAMPLES the folder with hud-direct/ and hud-diffuse/ (default: this repository's). Both HUDs are
converted to .usda, .usdc and .usdz and opened with usd-core. Checked are
- geometry: prims, transforms, points, triangles and faces against the .glb itself, which is parsed here;
- the three kinds of file against each other: every composed value of every prim, equal;
- every validator of UsdValidation, on these and on the samples' hud.usda: no error;
- the codeless schemas of schemas/usd/eyebox: every applied schema of ours is known, every `eyebox:` property declared,
  and the instanced LEDs emit from the face that looks along +z.
Exit status: 0 all agree, 1 they differ. Needs: numpy, usd-core (24.8 or later), both from PyPI.
"""
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMAS = ROOT / "schemas" / "usd" / "eyebox"
os.environ["PXR_PLUGINPATH_NAME"] = str(SCHEMAS)  # before pxr looks for plugins

import numpy as np  # noqa: E402
from pxr import Usd, UsdGeom, Vt  # noqa: E402

PROBLEMS = []


def check(holds, text):
    if not holds:
        PROBLEMS.append(text)
        print("FAILED:", text)


# The .glb, by the glTF 2.0 specification --------------------------------------------------------------------------

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
LANES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}


class Glb:
    def __init__(self, path):
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, lanes = np.dtype(TYPES[accessor["componentType"]]), LANES[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * lanes)
        rows = np.ndarray((accessor["count"], lanes), kind, self.binary, start, (stride, kind.itemsize))
        return rows.copy()

    def primitives(self, mesh):
        """-> per primitive: the positions of its triangles' corners, (3 n, 3) float32"""
        for primitive in self.json["meshes"][mesh]["primitives"]:
            points = self.accessor(primitive["attributes"]["POSITION"])
            yield points[self.accessor(primitive["indices"]).ravel()]

    def nodes(self):
        """-> path, local matrix for columns, mesh index or None; parents first"""
        open_ = [("", index) for index in reversed(self.json["scenes"][self.json.get("scene", 0)]["nodes"])]
        while open_:
            above, index = open_.pop()
            node = self.json["nodes"][index]
            path = f"{above}/{node['name']}"
            yield path, local(node), node.get("mesh")
            open_.extend((path, child) for child in reversed(node.get("children", [])))


def local(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= node.get("scale", [1.0, 1.0, 1.0])
    out[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return out


# The stage ----------------------------------------------------------------------------------------------------------

PROXIES = Usd.TraverseInstanceProxies()


def mesh_of(prim):
    found = [child for child in prim.GetFilteredChildren(PROXIES) if child.IsA(UsdGeom.Mesh)]
    return UsdGeom.Mesh(found[0]) if found else None


def faces_of(mesh):
    """-> per GeomSubset: the positions of its triangles' corners"""
    points = np.array(mesh.GetPointsAttr().Get(), np.float32)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    subsets = [UsdGeom.Subset(child) for child in mesh.GetPrim().GetFilteredChildren(PROXIES)]
    return [points[corners[np.array(subset.GetIndicesAttr().Get(), int)].ravel()] for subset in subsets if subset]


def geometry(glb, stage, name):
    nodes = list(glb.nodes())
    check(len(nodes) > 10, f"{name}: only {len(nodes)} nodes")
    faces = 0
    for path, matrix, mesh in nodes:
        prim = stage.GetPrimAtPath(path)
        check(bool(prim), f"{name}: no prim {path}")
        if not prim:
            continue
        found = np.array(UsdGeom.Xformable(prim).GetLocalTransformation()).T
        scale = max(1.0, np.abs(matrix).max())
        check(np.abs(found - matrix).max() <= 1e-15 * scale, f"{name}: transform of {path}")
        if mesh is None:
            check(mesh_of(prim) is None, f"{name}: {path} has a mesh")
            continue
        ours, theirs = faces_of(mesh_of(prim)), list(glb.primitives(mesh))
        check(len(ours) == len(theirs), f"{name}: {path} has {len(ours)} faces, not {len(theirs)}")
        same = all(a.tobytes() == b.tobytes() for a, b in zip(ours, theirs))
        check(same, f"{name}: corners of {path} differ")
        faces += len(ours)
    print(f"{name}: {len(nodes)} nodes, {faces} faces, as in the .glb")


def values(stage):
    """-> every composed attribute value, relationship and name of every prim, the prototypes' too"""
    out = {}
    for prim in stage.Traverse(PROXIES):
        path = str(prim.GetPath())
        out[path] = (prim.GetTypeName(), tuple(prim.GetAppliedSchemas()), prim.IsInstance(), prim.GetCustomData())
        for attribute in prim.GetAuthoredAttributes():
            value = attribute.Get()
            # Where an asset lies depends on the file; what it is called doesn't.
            out[str(attribute.GetPath())] = value.path if hasattr(value, "resolvedPath") else value
        for relationship in prim.GetAuthoredRelationships():
            out[str(relationship.GetPath())] = relationship.GetTargets()
    return out


def equal(a, b):
    if isinstance(a, (Vt.FloatArray, Vt.Vec2fArray, Vt.Vec3fArray, Vt.IntArray, Vt.DoubleArray)):
        return type(a) is type(b) and np.array(a).tobytes() == np.array(b).tobytes()
    return a == b


def validated(stage, name):
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    for error in errors:
        sites = [str(site.GetPrim().GetPath()) for site in error.GetSites() if site.IsPrim()]
        check(False, f"{name}: {error.GetName()} {error.GetMessage()} {sites}")
    print(f"{name}: {len(validators)} validators, {len(errors)} errors")


def schemas(stage, name):
    registry = Usd.SchemaRegistry()
    count = 0
    for prim in stage.TraverseAll():
        for schema in prim.GetAppliedSchemas():
            base = schema.split(":")[0]
            if base.startswith("Eyebox"):
                known = registry.FindAppliedAPIPrimDefinition(base) is not None
                check(known, f"{name}: {prim.GetPath()} has the unknown schema {schema}")
        own = [a for a in prim.GetAuthoredAttributes() if a.GetName().startswith("eyebox:")]
        declared = set(prim.GetPrimDefinition().GetPropertyNames())
        for attribute in own:
            count += 1
            # `default` may hold any property of a medium or a face, which no schema lists again.
            known = attribute.GetName() in declared or attribute.GetName().startswith("eyebox:default:")
            check(known, f"{name}: {attribute.GetPath()} is in no applied schema")
    check(count > 20, f"{name}: only {count} attributes")
    print(f"{name}: {count} attributes, all declared by applied schemas")


def leds(stage, name, instances):
    """The LEDs emit from the face that looks along their +z, and are instances if the asset has them so."""
    dies = [prim for prim in stage.Traverse() if prim.GetName().startswith("LED_DIE") and not prim.IsA(UsdGeom.Mesh)]
    check(len(dies) == 9, f"{name}: {len(dies)} LEDs")
    for prim in dies:
        check(prim.IsInstance() == instances, f"{name}: instance: {prim.GetPath()}")
        lit = [a for a in prim.GetAuthoredAttributes() if a.GetName().endswith(":emitter:flux_lm")]
        check(len(lit) == 1 and lit[0].Get() > 0, f"{name}: {prim.GetPath()} does not emit")
        for attribute in lit:
            prefix = attribute.GetName()[: -len("emitter:flux_lm")]
            numbers = prim.GetAttribute(prefix + "faces").Get()
            check(len(numbers) == 1, f"{name}: {prim.GetPath()} emits from {numbers}")
            a, b, c = faces_of(mesh_of(prim))[numbers[0]][:3].astype(float)
            normal = np.cross(b - a, c - a)
            check(np.allclose(normal / np.linalg.norm(normal), [0, 0, 1]), f"{name}: {prim.GetPath()} emits along {normal}")
    print(f"{name}: {len(dies)} LEDs emit along +z{', as instances' if instances else ''}")


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    eyebox = sys.argv[1]
    samples = pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else ROOT / "samples"
    print("usd-core", ".".join(map(str, Usd.GetVersion())))
    with tempfile.TemporaryDirectory() as folder:
        for hud in ("direct", "diffuse"):
            home = samples / f"hud-{hud}"
            glb = Glb(home / f"hud_{hud}.glb")
            # A package would have to hold the pictures, so it is made of the bare asset.
            bare, rich = home / f"hud_{hud}.glb", home / "hud.optics.toml"
            stages = {}
            for source, kind in ((rich, "usda"), (rich, "usdc"), (bare, "usdz")):
                out = pathlib.Path(folder) / f"{hud}.{kind}"
                subprocess.run([eyebox, "convert", source, out], check=True, stdout=subprocess.DEVNULL)
                stages[kind] = stage = Usd.Stage.Open(str(out))
                geometry(glb, stage, out.name)
                validated(stage, out.name)
            text, binary = values(stages["usda"]), values(stages["usdc"])
            check(text.keys() == binary.keys(), f"{hud}: other prims and properties in .usda and .usdc")
            for key in text.keys() & binary.keys():
                check(equal(text[key], binary[key]), f"{hud}: {key} differs between .usda and .usdc")
            print(f"{hud}: {len(text)} composed values are the same in .usda and .usdc")
            layer = Usd.Stage.Open(str(home / "hud.usda"))
            shared = len({mesh for path, _, mesh in glb.nodes() if "LED_DIE" in path}) == 1
            for stage, name, instances in (
                (stages["usda"], f"{hud}.usda", shared),
                (layer, f"hud-{hud}/hud.usda", True),
            ):
                leds(stage, name, instances)
                if SCHEMAS.is_dir():
                    schemas(stage, name)
            validated(layer, f"hud-{hud}/hud.usda")
            below = Usd.Stage.Open(str(home / f"hud_{hud}.usda"))
            for key in ("defaultPrim", "metersPerUnit", "upAxis"):
                check(layer.GetMetadata(key) == below.GetMetadata(key), f"hud-{hud}/hud.usda has another {key}")
    if not SCHEMAS.is_dir():
        check(False, f"there are no schemas in {SCHEMAS}")
    print("all agree" if not PROBLEMS else f"{len(PROBLEMS)} problems")
    sys.exit(1 if PROBLEMS else 0)


if __name__ == "__main__":
    main()
