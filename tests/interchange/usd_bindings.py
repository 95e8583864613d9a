"""Bound materials of every imported mesh and subset, against usd-core's UsdShadeMaterialBindingAPI.

usage: usd_bindings.py EYEBOX FOLDER...

Needs usd-core and numpy in the Python that runs it. For each FOLDER: every .usd, .usda, .usdc and .usdz that both programs
open. usd-core: for each gprim that is shown (as usd_corpus.py walks them) and each of its subsets of the family
`materialBind`, ComputeBoundMaterial for the purpose `full`, which falls back to all purposes. Faces that no subset covers, or
whose subset has no material, have the gprim's. eyebox: `inspect --geometry --format json`, `parts[].bound`. Compared are the triangles of each (gprim,
material), where prims in instances are named by where they stand and materials by their prim in the prototype. Beside
that it counts those that disagree only because eyebox honours the bindings of subsets of other families (CAD faces), which
usd-core's renderers do not ask for. One line per miss, one line of totals per folder; exit 1 if anything else differs.
"""

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

from usd_corpus import EXTENSIONS, IMPLICIT, LIMIT_S, Shown, eyebox, value

FAMILY = "materialBind"


class Bound(Shown):
    """Triangles of each (gprim, material) that a stage shows."""

    def __init__(self, stage, all_families):
        self.all_families = all_families
        self.triangles_of, self.instanced = Counter(), False
        super().__init__(stage)

    def material(self, prim):
        """The path of what is bound, in the prototype if it is in an instance; None for nothing."""
        from pxr import UsdShade

        found, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)
        return canonical(found.GetPrim()) if found else None

    def add(self, prim, triangles_by_material):
        for material, count in triangles_by_material.items():
            self.triangles_of[(str(prim.GetPath()), material)] += count

    def shape(self, prim, kind, world):
        super().shape(prim, kind, world)
        self.add(prim, {self.material(prim): IMPLICIT[kind]})

    def mesh(self, mesh, world):
        from pxr import UsdGeom

        super().mesh(mesh, world)
        np, prim = self.np, mesh.GetPrim()
        counts = np.array(value(mesh.GetFaceVertexCountsAttr()) or [], np.int64)
        keep = counts >= 3
        holes = np.array(value(mesh.GetHoleIndicesAttr()) or [], np.int64)
        keep[holes[(holes >= 0) & (holes < len(counts))]] = False
        key = prim.GetPrimInPrototype().GetPath() if prim.IsInstanceProxy() else mesh.GetPath()
        if not self.known[key][0]:
            return
        triangles = np.where(keep, counts - 2, 0)
        owner = [None] * len(counts)
        subsets = [UsdGeom.Subset(child) for child in children(prim) if child.GetTypeName() == "GeomSubset"]
        wanted = [subset for subset in subsets if value(subset.GetFamilyNameAttr()) == FAMILY]
        if self.all_families:
            wanted += [subset for subset in subsets if value(subset.GetFamilyNameAttr()) != FAMILY]
        whole = self.material(prim)
        for subset in wanted:
            if value(subset.GetElementTypeAttr()) not in (None, "face"):
                continue
            own = self.material(subset.GetPrim())
            if not own:
                continue
            for index in value(subset.GetIndicesAttr()) or []:
                if 0 <= index < len(owner) and owner[index] is None:
                    owner[index] = own
        out = Counter()
        for count, own in zip(triangles.tolist(), owner):
            out[own or whole] += count
        self.add(prim, {material: count for material, count in out.items() if count})


def children(prim):
    from pxr import Usd

    return prim.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))


def canonical(prim):
    """A material is known by its prim in the prototype, whose number means nothing: the list of where it comes from."""
    if prim.IsInstanceProxy():
        prim = prim.GetPrimInPrototype()
    if not prim.IsInPrototype():
        return str(prim.GetPath())
    return "prototype: " + " ".join(f"{spec.layer.identifier}<{spec.path}>" for spec in prim.GetPrimStack())


def ours(facts, stage):
    out = Counter()
    for part in facts["parts"]:
        for bound in part["bound"]:
            material = bound["at"] and canonical(stage.GetPrimAtPath(bound["at"]))
            if bound["triangles"]:
                out[(part["at"], material)] += bound["triangles"]
    return out


def apart(a, b):
    return [f"{prim}: {material} has {a[prim, material]} triangles, usd-core says {b[prim, material]}" for prim, material in sorted(set(a) | set(b), key=str) if a[prim, material] != b[prim, material]]


def compare(program, files):
    """One JSON object per file on standard output."""
    from pxr import Tf, Usd

    for file in files:
        print(json.dumps({"begin": file}), flush=True)
        out = {"file": file}
        try:
            stage = Usd.Stage.Open(file)
        except Tf.ErrorException:
            stage = None
        status, facts, _, _, _ = eyebox(program, file) if stage else (2, None, "", 0, 0)
        if status == 0:
            try:
                found, strict, wide = ours(facts, stage), Bound(stage, False).triangles_of, Bound(stage, True).triangles_of
                out.update(pairs=len(found), bound=sum(material is not None for _, material in found))
                out.update(strict=apart(found, strict), wide=apart(found, wide))
            except Exception as error:
                out["failed"] = f"{type(error).__name__}: {error}"[:300]
        print(json.dumps(out), flush=True)


def batches(program, files):
    """A process at a time, a new one after a crash or a hang of usd-core."""
    out, left = {}, list(files)
    while left:
        batch = left[:20]
        command = [sys.executable, __file__, "--compare", program, *batch]
        try:
            text = subprocess.run(command, capture_output=True, text=True, timeout=10 * LIMIT_S).stdout
        except subprocess.TimeoutExpired as expired:
            text = (expired.stdout or b"").decode()
        records = [json.loads(line) for line in text.splitlines() if line.startswith("{") and line.endswith("}")]
        out.update({record["file"]: record for record in records if "file" in record})
        for file in [record["begin"] for record in records if "begin" in record] or batch[:1]:
            out.setdefault(file, {"file": file, "crashed": True})
        left = [file for file in left if file not in out]
    return out


def main():
    if sys.argv[1:2] == ["--compare"]:
        return compare(sys.argv[2], sys.argv[3:])
    program, *folders = sys.argv[1:]
    good = True
    for folder in folders:
        files = sorted(str(f) for f in Path(folder).rglob("*") if f.suffix.lower() in EXTENSIONS and f.is_file())
        records = batches(program, files)
        compared, pairs, bound, strict, wide = 0, 0, 0, 0, 0
        for file in files:
            record = records[file]
            if "failed" in record or "crashed" in record:
                print(f"SCRIPT {file}: {record.get('failed', 'usd-core crashes or hangs')}")
            if "pairs" not in record:
                continue
            compared, pairs, bound = compared + 1, pairs + record["pairs"], bound + record["bound"]
            if not record["strict"]:
                continue
            strict += 1
            if record["wide"]:
                wide += 1
                print(f"MISS {file}: {len(record['wide'])} differ: " + "; ".join(record["wide"][:4]))
            else:
                print(f"OTHER FAMILY {file}: {record['strict'][0]}")
        good &= wide == 0
        print(f"{folder}: {compared} files, {pairs} pairs of gprim and material ({bound} with one); {compared - strict} files equal, {strict - wide} but for subsets of other families, {wide} differ")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
