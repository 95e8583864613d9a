"""glTF files that the reference validator calls valid, against what `eyebox inspect --geometry` makes of them.

usage: gltf_corpus.py EYEBOX SCRATCH FOLDER...

For each FOLDER: every .gltf and .glb is checked by npm's gltf-validator (installed into SCRATCH). Those without errors
must open, with the triangle and material counts that the validator reports and with the bounds that numpy finds from
the accessors' bytes and the nodes' matrices. One line per miss, one line of totals per folder; exit 1 below 99 %.
"""

import json
import math
import os
import struct
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import numpy as np

VALIDATOR = "gltf-validator@2.0.0-dev.3.10"
VALIDATE = r"""
const fs = require("fs"), path = require("path"), validator = require("gltf-validator");
(async () => {
  for (const file of fs.readFileSync(0, "utf8").split("\n").filter(Boolean)) {
    const near = (uri) => new Promise((resolve, reject) => fs.readFile(
      path.join(path.dirname(file), decodeURIComponent(uri)), (error, data) => error ? reject(error.toString()) : resolve(new Uint8Array(data))));
    let out;
    try {
      const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)),
        { uri: path.basename(file), maxIssues: 0, externalResourceFunction: near });
      out = { errors: report.issues.numErrors, messages: report.issues.messages.filter((m) => m.severity === 0).slice(0, 3), info: report.info };
    } catch (error) { out = { errors: -1, messages: [String(error)] }; }
    console.log(JSON.stringify({ file, ...out }));
  }
})();
"""
# A valid asset may say that a reader of glTF 2.0 must not read it (minVersion, extensionsRequired).
REFUSED = ("the asset asks for a newer reader", "the asset requires an extension that is not known")
TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
LANES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Asset:
    """The parts of glTF that bounds depend on, read a second time."""

    def __init__(self, file):
        data = Path(file).read_bytes()
        self.folder, self.bin = Path(file).parent, None
        if data[:4] == b"glTF":
            at = 12
            while at + 8 <= len(data):
                size, kind = struct.unpack_from("<II", data, at)
                if kind == 0x4E4F534A:
                    text = data[at + 8 : at + 8 + size]
                elif kind == 0x004E4942 and self.bin is None:
                    self.bin = data[at + 8 : at + 8 + size]
                at += 8 + size
        else:
            text = data
        self.json = json.loads(text)
        self.loaded = {}

    def buffer(self, index):
        index = int(index)
        if index not in self.loaded:
            uri = self.json["buffers"][index].get("uri")
            if uri is None:
                # Not in the asset: zeros, as an accessor without a view has.
                whole = self.bin if index == 0 and self.bin is not None else bytes(int(self.json["buffers"][index]["byteLength"]))
                self.loaded[index] = whole
            elif uri.startswith("data:"):
                import base64

                self.loaded[index] = base64.b64decode(uri.split(",", 1)[1] + "==")
            else:
                self.loaded[index] = (self.folder / unquote(uri)).read_bytes()
        return self.loaded[index]

    def view(self, view, start, count, lanes, dtype):
        view = self.json["bufferViews"][int(view)]
        size = np.dtype(dtype).itemsize
        stride = int(view.get("byteStride") or lanes * size)
        data = self.buffer(view["buffer"])
        start = int(start + view.get("byteOffset", 0))
        return np.ndarray((int(count), lanes), dtype, data, start, (stride, size))

    def accessor(self, index):
        a = self.json["accessors"][int(index)]
        dtype, lanes, count = np.dtype(TYPES[int(a["componentType"])]).newbyteorder("<"), LANES[a["type"]], int(a["count"])
        if "bufferView" in a:
            out = self.view(a["bufferView"], a.get("byteOffset", 0), count, lanes, dtype)
        else:
            out = np.zeros((count, lanes), dtype)
        if "sparse" in a:
            s, out = a["sparse"], out.copy()
            kind = np.dtype(TYPES[s["indices"]["componentType"]]).newbyteorder("<")
            where = self.view(s["indices"]["bufferView"], s["indices"].get("byteOffset", 0), s["count"], 1, kind)
            out[where[:, 0]] = self.view(s["values"]["bufferView"], s["values"].get("byteOffset", 0), s["count"], lanes, dtype)
        if a.get("normalized") and dtype.kind in "iu":
            out = np.maximum(out.astype(np.float64) / np.iinfo(dtype).max, -1.0)
        return out

    def points(self, mesh):
        """Positions of the vertices that triangles use."""
        all_points = [np.zeros((0, 3))]
        for primitive in self.json["meshes"][int(mesh)]["primitives"]:
            if primitive.get("mode", 4) < 4 or "POSITION" not in primitive.get("attributes", {}):
                continue
            points = self.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
            if "indices" in primitive:
                points = points[np.unique(self.accessor(primitive["indices"])[:, 0])]
            all_points.append(points)
        return np.concatenate(all_points)

    @staticmethod
    def compose(t, r, s):
        x, y, z, w = np.asarray(r, float) / math.sqrt(sum(c * c for c in r))
        turn = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ])
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = turn * np.asarray(s, float), t
        return m

    def local(self, node):
        if "matrix" in node:
            return np.array(node["matrix"], float).reshape(4, 4).T
        return self.compose(node.get("translation", [0, 0, 0]), node.get("rotation", [0, 0, 0, 1]), node.get("scale", [1, 1, 1]))

    def bounds(self):
        nodes = self.json.get("nodes", [])
        scenes = self.json.get("scenes")
        if "scene" in self.json:
            roots = scenes[int(self.json["scene"])].get("nodes", [])
        else:
            below = {child for node in nodes for child in node.get("children", [])}
            roots = [i for i in range(len(nodes)) if i not in below]
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        stack = [(root, np.eye(4)) for root in roots]
        while stack:
            index, above = stack.pop()
            node = nodes[int(index)]
            world = above @ self.local(node)
            stack += [(child, world) for child in node.get("children", [])]
            if "mesh" not in node:
                continue
            points = self.points(node["mesh"])
            copies = [np.eye(4)]
            instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
            if instancing:
                got = {k: self.accessor(v) for k, v in instancing["attributes"].items() if not k.startswith("_")}
                count = len(next(iter(got.values())))
                pick = lambda key, i, default: got[key][i] if key in got else default
                copies = [self.compose(pick("TRANSLATION", i, [0, 0, 0]), pick("ROTATION", i, [0, 0, 0, 1]), pick("SCALE", i, [1, 1, 1])) for i in range(count)]
            if len(points):
                for copy in copies:
                    m = world @ copy
                    there = points @ m[:3, :3].T + m[:3, 3]
                    low, high = np.minimum(low, there.min(0)), np.maximum(high, there.max(0))
        return None if np.isinf(low).any() else (low, high)


def same_bounds(ours, theirs):
    if ours is None or theirs is None:
        return ours is None and theirs is None
    scale = max(np.abs(theirs).max(), 1e-300)
    return all(np.abs(np.array(ours[key]) - there).max() <= 1e-12 * scale for key, there in zip(("low", "high"), theirs))


def check(eyebox, record):
    """What differs, as a text; none if nothing does."""
    ran = subprocess.run([eyebox, "inspect", record["file"], "--geometry", "--format", "json"], capture_output=True, text=True, timeout=60)
    if ran.returncode != 0:
        return f"exit {ran.returncode}: {ran.stderr.strip()[:300]}"
    totals, info = json.loads(ran.stdout)["totals"], record["info"]
    wrong = []
    for ours, theirs in (("mesh_triangles", "totalTriangleCount"), ("materials", "materialCount")):
        if totals[ours] != info.get(theirs, 0):
            wrong.append(f"{ours} {totals[ours]}, the validator says {info.get(theirs, 0)}")
    compressed = set(info.get("extensionsUsed", [])) & {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
    if not compressed:
        bounds = Asset(record["file"]).bounds()
        if not same_bounds(totals["bounds_m"], bounds):
            wrong.append(f"bounds {totals['bounds_m']}, numpy says {bounds}")
    return "; ".join(wrong) or None


def main():
    eyebox, scratch, *folders = sys.argv[1:]
    os.makedirs(scratch, exist_ok=True)
    if not Path(scratch, "node_modules/gltf-validator").exists():
        subprocess.run(["npm", "install", "--prefix", scratch, VALIDATOR], check=True, stdout=subprocess.DEVNULL)
    Path(scratch, "validate.js").write_text(VALIDATE)
    good = True
    for folder in folders:
        files = sorted(str(f) for f in Path(folder).rglob("*") if f.suffix.lower() in (".gltf", ".glb"))
        ran = subprocess.run(["node", "validate.js"], cwd=scratch, input="\n".join(str(Path(f).resolve()) for f in files), capture_output=True, text=True, check=True)
        records = [json.loads(line) for line in ran.stdout.splitlines()]
        valid = [r for r in records if r["errors"] == 0]
        misses, refused = [], 0
        for record in valid:
            try:
                wrong = check(eyebox, record)
            except Exception as error:  # the script's own reader failed: that is a miss, too
                wrong = f"{type(error).__name__}: {error}"
            if wrong and any(text in wrong for text in REFUSED):
                refused += 1
                print(f"REFUSED {record['file']}: {wrong}")
            elif wrong:
                misses.append(wrong)
                print(f"MISS {record['file']}: {wrong}")
        crashed = 0
        for record in records:
            if record["errors"] != 0:
                ran = subprocess.run([eyebox, "inspect", record["file"], "--geometry"], capture_output=True, timeout=60)
                crashed += ran.returncode not in (0, 2)
        readable = len(valid) - refused
        share = 1 - len(misses) / max(readable, 1)
        print(
            f"{folder}: {len(files)} files, {len(valid)} valid, {refused} of them rightly refused; {readable - len(misses)} of "
            f"{readable} open with equal counts and bounds ({100 * share:.2f} %); of the {len(records) - len(valid)} invalid "
            f"ones {crashed} crash"
        )
        good &= share >= 0.99 and crashed == 0
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
