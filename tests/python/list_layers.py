#!/usr/bin/env python3
"""list_layers.py FRAME.exr -- what two other EXR readers see in a frame that eyebox wrote.

Opens the file with OpenEXR (the reference library) and with OpenImageIO, lists layers, channels and attributes, and
checks that both give the same channel names, the same values bit by bit and the same attributes.
Exit status: 0 they agree, 1 they differ, 2 a reader cannot open the file.
Needs: numpy, OpenEXR (3.3 or later), OpenImageIO, all from PyPI.
"""
import sys

import numpy
import OpenEXR
import OpenImageIO


def with_openexr(path):
    """-> (channels: name -> float32 array (height, width), attributes: name -> value)"""
    with OpenEXR.File(path, separate_channels=True) as file:
        if len(file.parts) != 1:
            raise ValueError(f"{len(file.parts)} parts; eyebox writes one")
        part = file.parts[0]
        channels = {name: numpy.array(channel.pixels) for name, channel in part.channels.items()}
        return channels, dict(part.header)


def with_openimageio(path):
    """-> the same, as OpenImageIO has it"""
    image = OpenImageIO.ImageInput.open(path)
    if not image:
        raise ValueError(OpenImageIO.geterror())
    try:
        spec = image.spec()
        if image.seek_subimage(1, 0):
            raise ValueError("several parts; eyebox writes one")
        image.seek_subimage(0, 0)
        pixels = image.read_image(0, 0, 0, spec.nchannels, "unknown").reshape(spec.height, spec.width, spec.nchannels)
        channels = {name: pixels[..., index] for index, name in enumerate(spec.channelnames)}
        return channels, {attribute.name: attribute.value for attribute in spec.extra_attribs}
    finally:
        image.close()


def layers(names):
    """Channel names grouped by what stands before the last dot; '' is the default layer."""
    grouped = {}
    for name in sorted(names):
        layer, _, component = name.rpartition(".")
        grouped.setdefault(layer, []).append(component)
    return grouped


def ours(attributes):
    """The attributes that eyebox writes. OpenEXR hands out doubles as arrays of one; OpenImageIO drops empty texts."""
    named = {name: value.item() if isinstance(value, numpy.ndarray) and value.size == 1 else value
             for name, value in attributes.items()
             if name.startswith("eyebox.") or name in ("colorInteropID", "whiteLuminance")}
    return {name: value for name, value in named.items() if not (isinstance(value, str) and value == "")}


def main(arguments):
    if len(arguments) != 1 or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if arguments[:1] in (["-h"], ["--help"]) else 2
    path = arguments[0]
    try:
        (exr, exr_attributes), (oiio, oiio_attributes) = with_openexr(path), with_openimageio(path)
    except Exception as error:  # both libraries raise their own kinds
        print(f"{path}: cannot be read: {error}")
        return 2

    some = next(iter(exr.values()))
    print(f"{path}: {some.shape[1]} x {some.shape[0]}, {len(exr)} channels ({some.dtype})")
    for layer, components in layers(exr).items():
        print(f"  {layer or '(default)':<24} {' '.join(components)}")
    differences = []
    for name in sorted(set(exr) | set(oiio)):
        if name not in exr or name not in oiio:
            differences.append(f"channel {name} only in {'OpenEXR' if name in exr else 'OpenImageIO'}")
        elif exr[name].dtype != oiio[name].dtype or exr[name].tobytes() != oiio[name].tobytes():
            differences.append(f"channel {name} differs")
    ours_exr, ours_oiio = ours(exr_attributes), ours(oiio_attributes)
    for name in sorted(set(ours_exr) | set(ours_oiio)):
        value, other = ours_exr.get(name), ours_oiio.get(name)
        print(f"  {name:<24} {value!r}")
        if value != other:
            differences.append(f"attribute {name}: OpenEXR {value!r}, OpenImageIO {other!r}")
    for difference in differences:
        print("DIFFERENT", difference)
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
