#!/usr/bin/env python3
"""Rays through lens files by rayoptics and optiland, which are not ours, into FOLDER/rays.csv:

    pip install rayoptics==0.9.8 optiland==0.6.3
    python3 tests/python/prescription_rays.py tests/data/prescriptions

Lines of file, program, ray, wavelength in nm, surface, point, direction behind it, refractive index behind it; units and axes are
those of the file at surface 1, coordinate breaks are not counted as surfaces, and surface 0 is where the ray comes from. Any folder
of lens files will do: `EYEBOX_LENS_FILES=FOLDER cargo verify --test all rays_meet -- --nocapture` compares what was made of it.
"""

import sys
from pathlib import Path

import numpy as np
import rayoptics.environment as ro
from optiland.fileio import load_codev_file, load_zemax_file
from optiland.optic import Optic
from rayoptics.elem.elements import ElementModel
from rayoptics.raytr import raytrace, trace

# What it draws is not asked for, and its grammar of elements does not know every sequence.
ElementModel.update_model = lambda *args, **named: None

# Places in the pupil, of its radius.
PUPIL = [(0.0, 0.0), (0.0, 0.8), (0.6, -0.4), (-0.7, 0.1)]


def by_rayoptics(path):
    """Rays through the pupil, on the axis and at the rim of the field."""
    model, _ = ro.open_model(str(path), info=True)
    seq, nm = model.seq_model, model.optical_spec["wvls"].central_wvl
    breaks = [getattr(ifc, "z_type", "") == "COORDBRK" for ifc in seq.ifcs]
    for ifc in [ifc for ifc, broken in zip(seq.ifcs, breaks) if broken]:
        # OpticStudio's tilts about x and y are right-handed; rayoptics takes them for CODE V's.
        ifc.decenter.euler[:2] *= -1
        if ifc.decenter.dtype == "reverse":
            # Tilts before shifts undo what the negative of both does the other way round.
            ifc.decenter.euler *= -1
            ifc.decenter.dec *= -1
        ifc.decenter.update()
    model.update_model()
    fields = model.optical_spec["fov"].fields
    starts = []
    for field in fields[:1] + fields[1:][-1:]:
        for pupil in PUPIL:
            package, error = trace.trace_ray(model, list(pupil), field, nm, apply_vignetting=False)
            if package is not None and error is None:
                starts.append((np.array(package[0][1][0]), np.array(package[0][0][1])))
    turn, shift = seq.ifcs[1].decenter.tform_before_surf() if seq.ifcs[1].decenter else (None, np.zeros(3))
    turn = np.identity(3) if turn is None else turn
    # Far objects cost digits: the same rays, from a plane before surface 1.
    before = 10 + 2 * max([abs(point).max() for point, _ in starts], default=0)
    seq.gaps[0].thi = before
    seq.update_model()
    frames = seq.compute_global_coords(1)
    index = [step[3] for step in seq.path(wl=nm)]
    for point, way in starts:
        point = turn @ point + shift
        point = point - way * (point[2] + before) / way[2]
        hits = raytrace.trace_raw(seq.path(wl=nm), point + [0, 0, before], way, nm)[0]
        rows = [(point, way, 1.0)]
        for surface, hit in list(enumerate(hits))[1:]:
            if not breaks[surface]:
                rotation, origin = frames[surface]
                at, along = rotation @ hit[0] + origin, rotation @ hit[1]
                behind = index[surface] if index[surface] is not None else index[surface - 1]
                rows.append((turn @ at + shift, turn @ along, abs(behind)))
        yield nm, rows


def by_optiland(path):
    """The same, by optiland's reader."""
    optic = (load_zemax_file if path.suffix.lower() == ".zmx" else load_codev_file)(str(path))
    yield from through(optic, [0.0, 1.0] if any(field.x or field.y for field in optic.fields.fields) else [0.0])


def through(optic, fields):
    um = float(optic.primary_wavelength)
    surfaces = optic.surfaces
    index = [float(np.ravel(surface.material_post.n(um))[0]) for surface in surfaces.surfaces]
    for field in fields:
        for px, py in PUPIL:
            optic.trace_generic(0.0, field, px, py, um)
            x, y, z, *way = [np.reshape(getattr(surfaces, name), (len(index), -1))[:, 0] for name in "xyzLMN"]
            points, ways = np.stack([x, y, z], 1), np.stack(way, 1)
            if np.isfinite(points[1:]).all() and np.isfinite(ways).all():
                yield um * 1e3, [(points[1] - 20 * ways[0], ways[0], 1.0), *zip(points[1:], ways[1:], index[1:])]


def freeform(path):
    """Surfaces that no reader of theirs knows, made of the file's numbers by optiland's own."""
    numbers = {}
    for line in path.read_text().splitlines():
        words = line.split()
        if words[0] == "SURF":
            numbers[int(words[1])] = surface = {"xdat": {}}
        elif words[0] == "XDAT":
            surface["xdat"][int(words[1])] = float(words[2])
        elif words[0] in ("CURV", "CONI"):
            surface[words[0]] = float(words[1])

    def terms(index):
        xdat = numbers[index]["xdat"]
        return [xdat[k] for k in range(3, 3 + int(xdat[1]))], xdat[2]

    given, radius = terms(2)
    table, place = np.zeros((8, 8)), 0
    for degree in range(1, 8):
        for power in range(degree + 1):
            if place < len(given):
                table[degree - power, power] = given[place] / radius**degree
                place += 1
    optic = Optic()
    exact = {"tol": 1e-15, "max_iter": 300}
    base = {index: {"radius": 1 / numbers[index]["CURV"], "conic": numbers[index]["CONI"], **exact} for index in (2, 3, 4)}
    optic.surfaces.add(index=0, thickness=np.inf)
    optic.surfaces.add(index=1, thickness=12, is_stop=True)
    optic.surfaces.add(
        index=2, surface_type="polynomial", thickness=6, material="N-BK7", coefficients=table, **base[2]
    )
    for index, kind, thickness, material in [(3, "noll", 40, "air"), (4, "fringe", -60, "mirror")]:
        given, radius = terms(index)
        optic.surfaces.add(
            index=index,
            surface_type="zernike",
            thickness=thickness,
            material=material,
            coefficients=given,
            zernike_type=kind,
            norm_radius=radius,
            **base[index],
        )
    optic.surfaces.add(index=5)
    optic.set_aperture("EPD", 8)
    optic.fields.set_type("angle")
    optic.fields.add(y=0)
    optic.fields.add(y=5)
    optic.wavelengths.add(0.55, is_primary=True)
    yield from through(optic, [0.0, 1.0])


def main(folder):
    tried = {"rayoptics": by_rayoptics, "optiland": by_optiland}
    with open(folder / "rays.csv", "w") as out:
        out.write("# Made by tests/python/prescription_rays.py: rayoptics 0.9.8, optiland 0.6.3\n")
        for path in sorted(path for path in folder.rglob("*") if path.suffix.lower() in (".zmx", ".seq")):
            name = str(path.relative_to(folder))
            for program, rays in {"optiland": freeform}.items() if path.name == "freeform.zmx" else tried.items():
                try:
                    for ray, (nm, rows) in enumerate(rays(path)):
                        for surface, (point, way, index) in enumerate(rows):
                            cells = [nm, surface, *point, *way, index]
                            out.write(f"{name.replace(',', '_')},{program},{ray}," + ",".join(f"{v!r}" for v in map(float, cells)) + "\n")
                except Exception as fault:  # What they do not read is no row.
                    print(f"{name}: {program}: {type(fault).__name__}: {fault}"[:120], file=sys.stderr)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
