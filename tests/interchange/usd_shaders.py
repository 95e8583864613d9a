"""Defaults of the surface shaders that are mapped, against UsdPreviewSurface in usd-core and MaterialX's node definitions.

usage: usd_shaders.py EYEBOX SCRATCH

Needs usd-core and MaterialX in the Python that runs it. For every input that has a default in the definitions (Sdr registry
of usd-core; `standard_surface` 1.0.0 and 1.0.1, `open_pbr_surface`, `UsdPreviewSurface` in MaterialX's library) and for
several materials that say something else already: saying the default must change nothing of what `inspect` reports of the
part (medium, finish, coating, emitter). Beside that, every input that is mapped must be one that the definition has, and
must change something when it is given another value: else its name is wrong. One line per miss; exit 1 if there is one.
"""

import json
import subprocess
import sys
from pathlib import Path

# An index that is said is that of a medium, also behind a surface that lets nothing through; one that is not said is the
# default only if light gets there. So saying it changes what is reported where nothing is transmitted, not what is seen.
INDEX = ("ior", "specular_IOR", "specular_ior")
TRANSMITS = ("transmission", "transmission_weight")
TYPES = {"float": "float", "color3": "color3f", "boolean": "bool", "integer": "int"}
# What is said already, so that the inputs that only then count do count.
BASES = {
    "UsdPreviewSurface": [{}, {"ior": 1.7}],
    "standard_surface": [
        {},
        {"transmission": 1.0, "transmission_depth": 0.3, "transmission_color": (0.2, 0.4, 0.6), "specular_IOR": 1.6},
        {"transmission": 1.0, "transmission_dispersion": 30.0},
        {"thin_film_thickness": 300.0, "transmission": 1.0},
    ],
    "open_pbr_surface": [
        {},
        {"transmission_weight": 1.0, "transmission_depth": 0.3, "transmission_color": (0.2, 0.4, 0.6), "specular_ior": 1.6},
        {"transmission_weight": 1.0, "transmission_dispersion_scale": 1.0},
        {"thin_film_weight": 1.0, "transmission_weight": 1.0},
        {"emission_luminance": 500.0},
    ],
}
# Another value of each input that is mapped to light, and the base (its number above) in which it must show.
MAPPED = {
    "UsdPreviewSurface": {"ior": (1.8, 0)},
    "standard_surface": {
        "specular_IOR": (1.8, 1), "transmission": (1.0, 0), "transmission_depth": (0.5, 1), "transmission_color": ((0.5, 0.5, 0.5), 1),
        "transmission_dispersion": (40.0, 1), "thin_walled": (1, 1), "thin_film_thickness": (250.0, 3), "thin_film_IOR": (1.7, 3),
    },
    "open_pbr_surface": {
        "specular_ior": (1.8, 1), "transmission_weight": (1.0, 0), "transmission_depth": (0.5, 1), "transmission_color": ((0.5, 0.5, 0.5), 1),
        "transmission_dispersion_scale": (0.5, 1), "transmission_dispersion_abbe_number": (40.0, 2), "geometry_thin_walled": (1, 1),
        "thin_film_weight": (1.0, 1), "thin_film_thickness": (0.25, 3), "thin_film_ior": (1.7, 3), "emission_luminance": (7.0, 0),
        "emission_color": ((0.5, 0.5, 0.5), 4),
    },
}


def definitions():
    """(where from, model, id in USD, {input: (type, default)})"""
    import MaterialX as mx
    from pxr import Sdr

    node = Sdr.Registry().GetShaderNodeByIdentifier("UsdPreviewSurface")
    inputs = {}
    for name in node.GetShaderInputNames():
        own = node.GetShaderInput(name)
        kind = {"color": "color3f", "float": "float", "int": "int"}.get(str(own.GetType()))
        default = own.GetDefaultValue()
        if kind:
            inputs[name] = (kind, tuple(default) if kind == "color3f" else default)
    yield "usd-core", "UsdPreviewSurface", "UsdPreviewSurface", inputs
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    for definition in library.getNodeDefs():
        if definition.getNodeString() not in BASES:
            continue
        inputs = {}
        for own in definition.getActiveInputs():
            kind, text = TYPES.get(own.getType()), own.getValueString()
            if kind and text:
                numbers = tuple(float(x) for x in text.split(",")) if own.getType() in ("float", "color3") else (int(text in ("true", "1")),)
                inputs[own.getName()] = (kind, numbers if kind == "color3f" else numbers[0])
        yield f"MaterialX {mx.getVersionString()}", definition.getNodeString(), definition.getName(), inputs


def seen(program, scratch, shader, variants, kinds):
    """What `inspect` says of a part for each variant (inputs and their values)."""
    bodies = []
    for number, said in enumerate(variants):
        inputs = "\n".join(f"   {kinds[key]} inputs:{key} = {value}" for key, value in said.items())
        context = "surface" if shader == "UsdPreviewSurface" else "mtlx:surface"
        bodies.append(
            f'def Xform "V{number}" {{\n double3 xformOp:translate = ({5 * number}, 0, -20)\n uniform token[] xformOpOrder = ["xformOp:translate"]\n'
            f' def Cube "P{number}" (\n  prepend apiSchemas = ["MaterialBindingAPI"]\n ) {{\n  rel material:binding = </V{number}/M>\n }}\n'
            f' def Material "M" {{\n  token outputs:{context}.connect = </V{number}/M/S.outputs:out>\n  def Shader "S" {{\n   uniform token info:id = "{shader}"\n{inputs}\n   token outputs:out\n  }}\n }}\n}}\n'
        )
    file = Path(scratch) / f"{shader}.usda"
    eye = 'def Camera "Eye" {\n float horizontalAperture = 10\n float verticalAperture = 10\n float focalLength = 100\n}\n'
    file.write_text('#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Y"\n)\n' + eye + "".join(bodies))
    sidecar = file.with_suffix(".optics.toml")
    # The asset's materials come before it.
    sidecar.write_text(f'schema = 1\nasset = "{file.name}"\n[default]\nfinish = "absorber"\n')
    ran = subprocess.run([program, "inspect", str(sidecar), "--format", "json"], capture_output=True, text=True)
    if not ran.stdout:
        sys.exit(f"{file}: {ran.stderr}")
    # As far as single precision says it.
    tree = json.loads(ran.stdout, parse_float=lambda text: float(f"{float(text):.6g}"))
    if tree.get("fault"):
        sys.exit(f"{file}: {tree['fault']}")
    out = {}
    for part in tree["parts"]:
        said = [part["medium"], [[face[key] for key in ("finish", "coating", "emitter")] for face in part["faces"]]]
        # Names of groups and media are those of the parts.
        number = int(part["path"].split("/")[0][1:])
        out[number] = json.dumps(said).replace(f"P{number}", "P").replace(f"V{number}", "V")
    return [out[number] for number in range(len(variants))]


def main():
    program, scratch = sys.argv[1:]
    Path(scratch).mkdir(parents=True, exist_ok=True)
    bad, checked, shown = 0, 0, 0
    for source, model, shader, inputs in definitions():
        kinds = {name: kind for name, (kind, _) in inputs.items()}
        for name in [name for name in MAPPED[model] if name not in inputs]:
            bad += 1
            print(f"MISS {source} {shader}: no input {name}")
        variants, meant = [], []
        for base_number, base in enumerate(BASES[model]):
            start = len(variants)
            variants.append(base)
            meant.append(None)
            for name, (_, default) in inputs.items():
                if name not in base and (name not in INDEX or any(key in base for key in TRANSMITS)):
                    variants.append({**base, name: default})
                    meant.append((start, name, default, True))
            for name, (value, where) in MAPPED[model].items():
                if where == base_number and name in inputs:
                    variants.append({**base, name: value})
                    meant.append((start, name, value, False))
        found = seen(program, scratch, shader, variants, kinds)
        for own, what in zip(found, meant):
            if what is None:
                continue
            start, name, value, same = what
            checked, shown = checked + same, shown + (not same)
            if (own == found[start]) != same:
                bad += 1
                print(f"MISS {source} {shader}.{name} = {value} beside {variants[start]}: {own}, without it {found[start]}")
        print(f"{source} {shader}: {len(inputs)} inputs with defaults, {len(variants)} parts")
    print(f"{checked} defaults that change nothing, {shown} values that do, {bad} misses")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
