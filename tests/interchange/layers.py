#!/usr/bin/env python3
"""layers.py EYEBOX SCRATCH [BLENDER_PYTHON] -- layers and mattes of a rendered sample in other programs.

Renders the sample hud-direct with one pass, wide enough that the combiner's edges show: as one part, with a prefix, and
with a part per layer. Checks with OpenImageIO and OpenEXR the names of the layers, that `hybrid` is the f32 sum of the
layers and the layers of their groups, and of each Cryptomatte that every identity is in the manifest, that the manifest has the hashes
of PyPI mmh3, and that coverages add up to 1. With BLENDER_PYTHON (a Python that has bpy, which wants another
numpy) Blender's compositor adds up the layers and picks a matte by role, and both must be ours.
Exit status: 0 all agree, 1 something differs.
Needs: numpy, OpenEXR (3.3 or later), OpenImageIO, mmh3 from PyPI; bpy 5 in its own environment.
"""
import json
import pathlib
import subprocess
import sys

import mmh3
import numpy
import OpenEXR
import OpenImageIO

SAMPLE = pathlib.Path(__file__).resolve().parents[2] / "samples/hud-direct/hud.optics.toml"
LAYERS = ["direct", "caustic", "secondary", "forward"]
MATTES = ["CryptoPart", "CryptoRole", "CryptoPartSeen", "CryptoRoleSeen"]
PICK = "combiner"
BLENDER = """
import bpy, sys
path, matte, name, layers, width, height = sys.argv[1:7]
scene = bpy.context.scene
image = bpy.data.images.load(path)
tree = bpy.data.node_groups.new("c", "CompositorNodeTree")
scene.compositing_node_group = tree
tree.interface.new_socket(name="Image", in_out="OUTPUT", socket_type="NodeSocketColor")
node = tree.nodes.new("CompositorNodeImage")
node.image = image
print("SOCKETS", *[socket.name for socket in node.outputs])
crypto = tree.nodes.new("CompositorNodeCryptomatteV2")
crypto.source, crypto.image, crypto.layer_name, crypto.matte_id = "IMAGE", image, matte, name
out = tree.nodes.new("NodeGroupOutput")
last = None
for layer in layers.split(","):
    socket = node.outputs[layer]
    if last is None:
        last = socket
        continue
    add = tree.nodes.new("ShaderNodeMix")
    add.data_type, add.blend_type, add.inputs[0].default_value = "RGBA", "ADD", 1.0
    tree.links.new(last, add.inputs[6])
    tree.links.new(socket, add.inputs[7])
    last = add.outputs[2]
scene.render.engine, scene.cycles.samples = "CYCLES", 1
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = int(width), int(height), 100
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
for socket, file in ((last, path + ".sum.exr"), (crypto.outputs["Matte"], path + ".matte.exr")):
    tree.links.new(socket, out.inputs[0])
    scene.render.filepath = file
    bpy.ops.render.render(write_still=True)
"""


def read(path):
    """-> (name -> float32 array, attributes, names of the parts), as OpenImageIO has them"""
    image = OpenImageIO.ImageInput.open(str(path))
    channels, attributes, parts, index = {}, {}, [], 0
    while image.seek_subimage(index, 0):
        spec = image.spec()
        pixels = image.read_image(index, 0, 0, spec.nchannels, "float").reshape(spec.height, spec.width, spec.nchannels)
        channels.update({name: pixels[..., k] for k, name in enumerate(spec.channelnames)})
        if index == 0:
            attributes = {attribute.name: attribute.value for attribute in spec.extra_attribs}
        parts.append(spec.getattribute("oiio:subimagename"))
        index += 1
    return channels, attributes, parts


def matte(channels, attributes, name):
    """-> (identity -> coverage per pixel, name -> identity, the attribute's key)"""
    [key] = [key[:-len("/name")] for key, value in attributes.items()
             if key.startswith("cryptomatte/") and key.endswith("/name") and value == name]
    assert attributes[key + "/hash"] == "MurmurHash3_32" and attributes[key + "/conversion"] == "uint32_to_float32"
    coverage, layer = {}, 0
    while f"{name}{layer:02}.r" in channels:
        for identity, share in ("rg", "ba"):
            bits = numpy.ascontiguousarray(channels[f"{name}{layer:02}.{identity}"]).view(numpy.uint32)
            part = channels[f"{name}{layer:02}.{share}"]
            for one in numpy.unique(bits[part > 0]):
                coverage.setdefault(int(one), numpy.zeros_like(part))
                coverage[int(one)] += numpy.where(bits == one, part, 0)
        layer += 1
    assert layer == 3, f"{name} has {layer} layers"
    return coverage, {n: int(h, 16) for n, h in json.loads(attributes[key + "/manifest"]).items()}, key


def identity(name):
    bits = mmh3.hash(name.encode(), signed=False)
    return bits ^ 1 << 23 if bits >> 23 & 255 in (0, 255) else bits


def main(eyebox, scratch, blender=None):
    scratch, faults = pathlib.Path(scratch), []
    scratch.mkdir(parents=True, exist_ok=True)

    def check(what, holds):
        print("ok       " if holds else "DIFFERENT", what)
        if not holds:
            faults.append(what)

    def render(name, *options):
        path = scratch / f"{name}.exr"
        subprocess.run([eyebox, "render", SAMPLE, "-o", path, "--samples", "1", "-q", "--cryptomatte", "--resolution", "120x90",
                        "--set", "eye.fov_deg=70", "--aov", "ours=C.*", *options], check=True)
        return path

    plain = render("plain")
    channels, attributes, _ = read(plain)
    exr = OpenEXR.File(str(plain), separate_channels=True).parts[0].channels
    check("OpenImageIO and OpenEXR read the same channels, bit by bit", sorted(exr) == sorted(channels) and all(
        exr[name].pixels.tobytes() == numpy.ascontiguousarray(channels[name]).tobytes() for name in exr))
    groups = json.loads(attributes["eyebox.groups"])
    for component in "RGB":
        total = numpy.zeros_like(channels["R"])
        for layer in (layer for layer in LAYERS if f"{layer}.R" in channels):
            own = [channels[f"{layer}_{group}.{component}"] for group in groups if f"{layer}_{group}.R" in channels]
            check(f"{layer}.{component} is the sum of its {len(own)} groups",
                  (sum(own, numpy.zeros_like(total)) == channels[f"{layer}.{component}"]).all())
            total = total + channels[f"{layer}.{component}"]
        check(f"hybrid.{component} is the sum of the layers", (total == channels[f"hybrid.{component}"]).all())
        check(f"{component} and the layer `ours` (C.*) are hybrid", (total == channels[component]).all()
              and (total == channels[f"ours.{component}"]).all())
    for name in MATTES:
        coverage, manifest, key = matte(channels, attributes, name)
        check(f"{name}: every identity is in the manifest", all(one in (0, *manifest.values()) for one in coverage))
        check(f"{name}: {len(manifest)} names have mmh3's hashes", all(identity(n) == h for n, h in manifest.items()))
        check(f"{name}: coverages add up to 1", (sum(coverage.values()) == 1).all())
        check(f"{name}: the key is the name's hash", key == f"cryptomatte/{identity(name):08x}"[:-1])
    roles, manifest, _ = matte(channels, attributes, "CryptoRole")
    picked = roles[manifest[PICK]]
    check(f"the {PICK} has an edge in the picture", ((picked > 0) & (picked < 1)).any() and (picked == 1).any())

    for name, prefix, options in (("prefix", "eb_", ["--layer-prefix", "eb_"]), ("parts", "", ["--multi-part"]),
                                  ("both", "eb_", ["--multi-part", "--layer-prefix", "eb_"])):
        other, said, parts = read(render(name, *options))
        renamed = {prefix + n if "." in n else n: pixels for n, pixels in channels.items()}
        check(f"{name}: the same channels under their names", sorted(other) == sorted(renamed)
              and all((other[n] == pixels).all() for n, pixels in renamed.items()))
        check(f"{name}: mattes are found by their names", all(
            matte(other, said, prefix + n)[0].keys() == matte(channels, attributes, n)[0].keys() for n in MATTES))
        if "--multi-part" in options:
            want = {n.rpartition(".")[0] or n for n in renamed} - set("RGB")
            check(f"{name}: {len(parts)} parts, the picture's first", parts[0] == "picture" and set(parts[1:]) == want)

    if blender:
        there = [layer for layer in LAYERS if f"{layer}.R" in channels]
        height, width = channels["R"].shape
        for path, prefix in ((plain, ""), (scratch / "prefix.exr", "eb_"), (scratch / "parts.exr", "")):
            ran = subprocess.run([blender, "-c", BLENDER, path, prefix + "CryptoRole", PICK,
                                  ",".join(prefix + layer for layer in there), str(width), str(height)],
                                 capture_output=True, text=True)
            if ran.returncode:
                check(f"Blender reads {path.name}: {ran.stderr.strip().splitlines()[-1]}", False)
                continue
            pixels = {kind: OpenEXR.File(f"{path}.{kind}.exr", separate_channels=True).parts[0].channels["R"].pixels
                      for kind in ("sum", "matte")}
            check(f"Blender, {path.name}: direct + … + forward is hybrid", (pixels["sum"] == channels["hybrid.R"]).all())
            check(f"Blender, {path.name}: its matte of `{PICK}` is the coverage", (pixels["matte"] == picked).all())
    print(f"{len(faults)} differ")
    return 1 if faults else 0


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
