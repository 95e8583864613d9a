#!/usr/bin/env python3
"""validator_table.py EYEBOX SCRATCH FOLDER [--markdown FILE] -- eyebox validate beside Khronos' glTF-Validator.

Both look at every .gltf and .glb below FOLDER (a checkout of KhronosGroup/glTF-Validator). eyebox may exit with 0 or 1
only, within a minute an asset. Per code of the validator: assets with it, and how many of them eyebox finds unsound in
reading (EB00xx and EB01xx, errors and warnings; but EB0114: most of these assets have no geometry). A bare asset says
nothing of light, so findings about that don't count. The validator is npm gltf-validator, installed into SCRATCH. Needs: Node.js with npm.
"""
import collections
import json
import pathlib
import subprocess
import sys

program, scratch, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
SCRIPT = """
const fs = require("fs"), path = require("path"), validator = require("gltf-validator");
(async () => {
  for (const file of fs.readFileSync(0, "utf8").split("\\n").filter(Boolean)) {
    const near = (uri) => new Promise((resolve, reject) => fs.readFile(path.join(path.dirname(file), decodeURIComponent(uri)),
      (error, data) => error ? reject(error.toString()) : resolve(new Uint8Array(data))));
    let codes;
    try {
      const bytes = new Uint8Array(fs.readFileSync(file));
      const report = await validator.validateBytes(bytes, { uri: path.basename(file), maxIssues: 0, externalResourceFunction: near });
      codes = report.issues.messages.filter((m) => m.severity === 0).map((m) => m.code);
    } catch (error) { codes = ["NOT_GLTF"]; }
    console.log(JSON.stringify({ file, codes: [...new Set(codes)] }));
  }
})();
"""
if not (scratch / "node_modules" / "gltf-validator").exists():
    subprocess.run(["npm", "install", "--silent", "--prefix", scratch, "gltf-validator"], check=True)
(scratch / "table.js").write_text(SCRIPT)
files = sorted(str(file) for file in folder.rglob("*") if file.suffix in (".gltf", ".glb"))
lines = subprocess.run(["node", scratch / "table.js"], input="\n".join(files), capture_output=True, text=True, check=True).stdout
total, agree = collections.Counter(), collections.Counter()
sound, objected, broken = 0, collections.Counter(), []
for line in lines.splitlines():
    judged = json.loads(line)
    try:
        done = subprocess.run([program, "validate", judged["file"], "--format", "json"], capture_output=True, text=True, timeout=60)
    except subprocess.TimeoutExpired:
        broken.append((judged["file"], "timeout"))
        continue
    if done.returncode not in (0, 1):
        broken.append((judged["file"], done.returncode, done.stderr[-300:]))
        continue
    findings = json.loads(done.stdout)["findings"]
    own = {f["code"] for f in findings if f["code"] < "EB02" and f["level"] != "note"} - {"EB0114"}
    for code in judged["codes"]:
        total[code] += 1
        agree[code] += bool(own)
    if not judged["codes"]:
        sound += 1
        objected.update(own)
print(f"{len(files)} files, {sound} valid; ended otherwise than with 0 or 1: {broken}")
print(f"of the valid ones eyebox says: {dict(objected)}")
for code, count in sorted(total.items()):
    print(f"{code:60} {count:4} {agree[code]:4}")
sys.exit(bool(broken))
