#!/usr/bin/env python3
"""Makes database.bin from a checkout of the refractiveindex.info database (public domain, CC0):

    git clone https://github.com/polyanskiy/refractiveindex.info-database
    python3 src/scene/glass/make_database.py refractiveindex.info-database/database src/scene/glass/database.bin

Formulas keep their coefficients digit by digit. Tables lose rows, never names: a row goes where the line between its kept
neighbours passes close by. From 360 to 830 nm that is within half a unit of its last digit, at most 1e-4 of |n + ik| and at
least 1e-5 of it (1e-3 where k stands alone); beyond, within 1e-3, and n and k are rounded to five digits there. Pages with k
alone have no index and are left out.
src/scene/glass/database.rs reads the file and says how it is laid out.
"""

import html
import re
import struct
import sys
import zlib
from decimal import Decimal
from pathlib import Path

import yaml

SEEN_UM = (0.36, 0.83)
FDC_UM = (0.4861327, 0.6562725)
BLOCK = 1 << 15


def plain(text):
    """Without markup, in one line."""
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", "", text))).strip()


def last_digit(text):
    return 10.0 ** Decimal(text).as_tuple().exponent


def rounded(text, digits):
    value = Decimal(text)
    shift = value.adjusted() - digits + 1
    return value if value.as_tuple().exponent >= shift else value.quantize(Decimal(1).scaleb(shift))


def table(data):
    """Rows of decimals by rising wavelength; of rows with one wavelength the first counts. Below 0 is noise about 0."""
    cells = ([c if float(c) > 0 else "0" for c in line.split()] for line in data.strip().splitlines() if line.split())
    rows = sorted(cells, key=lambda row: float(row[0]))
    return [row for i, row in enumerate(rows) if i == 0 or float(row[0]) > float(rows[i - 1][0])]


def thinned(rows, k_alone):
    """The rows that linear interpolation needs; from each kept one, the farthest whose line misses none between."""
    exact = [[float(cell) for cell in row] for row in rows]
    within, kept_as = [], []
    for row, numbers in zip(rows, exact):
        seen = SEEN_UM[0] <= numbers[0] <= SEEN_UM[1]
        size = sum(v * v for v in numbers[1:]) ** 0.5
        near = 1e-3 if k_alone else 1e-5
        within.append([max(min(last_digit(c) / 2, 1e-4 * size), near * size) if seen else 1e-3 * size for c in row[1:]])
        kept_as.append([Decimal(row[0])] + [rounded(c, 7 if seen else 5) for c in row[1:]])
    values = [[float(cell) for cell in row] for row in kept_as]
    keep, i = [0], 0
    while i < len(rows) - 1:
        low, high, best, j = [-1e300] * 2, [1e300] * 2, i + 1, i + 1
        while j < len(rows):
            run = values[j][0] - values[i][0]
            slopes = [(v - u) / run for v, u in zip(values[j][1:], values[i][1:])]
            if all(l <= s <= h for l, s, h in zip(low, slopes, high)):
                best = j
            for c, (v, u, t) in enumerate(zip(exact[j][1:], values[i][1:], within[j])):
                low[c], high[c] = max(low[c], (v - t - u) / run), min(high[c], (v + t - u) / run)
            if any(l > h for l, h in zip(low, high)):
                break
            j += 1
        keep.append(best)
        i = best
    return [kept_as[i] for i in keep]


def varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes(out) + bytes([value])


def signed(value):
    return varint(value << 1 if value >= 0 else (-value << 1) - 1)


def text(value):
    raw = value.encode()
    return varint(len(raw)) + raw


def column(values):
    """As steps of one decimal place, or each with its own exponent; what is shorter."""
    places = max(max(0, -v.as_tuple().exponent) for v in values)
    steps, before = bytes([0]) + varint(places), 0
    for value in values:
        whole = int(value.scaleb(places))
        steps, before = steps + signed(whole - before), whole
    own, at = bytes([1]), 0
    for value in values:
        value = value.normalize()
        sign, digits, exponent = value.as_tuple()
        whole = int("".join(map(str, digits))) * (-1 if sign else 1)
        own, at = own + signed(exponent - at) + signed(whole), exponent
    return min(steps, own, key=len) if places <= 17 else own


def part(item):
    kind = item["type"]
    if kind.startswith("formula"):
        low, high = map(str, item["wavelength_range"].split())
        return bytes([int(kind.split()[1])]) + text(" ".join([low, high, item["coefficients"].strip()]))
    rows = thinned(table(item["data"]), item["type"] == "tabulated k")
    code = {"tabulated n": 10, "tabulated k": 11, "tabulated nk": 12}[kind]
    return bytes([code]) + varint(len(rows)) + b"".join(column([row[c] for row in rows]) for c in range(len(rows[0])))


def covers(page):
    """Whether a page knows n over the visible."""
    for item in page["DATA"]:
        if item["type"].startswith("formula"):
            low, high = map(float, item["wavelength_range"].split())
        elif item["type"] != "tabulated k":
            rows = table(item["data"])
            low, high = float(rows[0][0]), float(rows[-1][0])
        else:
            continue
        return low <= FDC_UM[0] and high >= FDC_UM[1]
    return False


def pages(root):
    for shelf in yaml.load((root / "catalog-nk.yml").read_text("utf-8"), yaml.CSafeLoader):
        for book in shelf.get("content", []) if "SHELF" in shelf else []:
            for page in book.get("content", []) if "BOOK" in book else []:
                if "PAGE" in page:
                    yield shelf["SHELF"], book["BOOK"], page["PAGE"], plain(str(page["name"])), page["data"]


def letters(name):
    return "".join(c.upper() if c.isascii() else c for c in name if c not in "-_ /")


def main(root, out):
    entries, names, number, books = [], [], {}, {}
    for shelf, book, page, title, file in pages(root):
        read = None
        if file not in number:
            read = yaml.load((root / "data" / file).read_text("utf-8"), yaml.CSafeLoader)
            if all(item["type"] == "tabulated k" for item in read["DATA"]):
                continue
            vendor = book.split("-")[0] if shelf == "specs" else None
            own = f"{vendor} {page}" if vendor else f"{shelf}/{book}/{page}"
            source = plain(read.get("REFERENCES") or "")
            source = source if len(source) <= 160 else source[:160].rsplit(" ", 1)[0] + " …"
            source = source if vendor else f"{title}; {source}"
            number[file] = len(entries)
            # A table of n beside the formula that was fitted to it gives its k alone: the formula is the page's n.
            data = read["DATA"][:1]
            for extra in read["DATA"][1:]:
                k = extra["data"] if extra["type"] == "tabulated k" else "\n".join(f"{r[0]} {r[-1]}" for r in table(extra["data"]))
                data.append({"type": "tabulated k", "data": k})
            raw = text(own) + text(source) + bytes([shelf == "specs"]) + varint(len(data)) + b"".join(map(part, data))
            entries.append(raw)
            if vendor:
                names += [(own, 0, number[file]), (page, 1, number[file])]
            else:
                names.append((f"{book} {page}", 2, number[file]))
        names.append((f"{shelf}/{book}/{page}", 0, number[file]))
        if shelf not in ("specs", "3d", "popular_glass"):
            known = books.setdefault(book, [number[file], False])
            if read and not known[1] and covers(read):
                books[book] = [number[file], True]
    names += [(book, 3, entry) for book, (entry, _) in books.items()]
    once = {}
    for name, rank, entry in sorted(names, key=lambda n: (letters(n[0]), n[1], n[2])):
        once.setdefault((letters(name), name), (name, entry))
    rows = list(once.values())

    places, blocks, block = [], [], b""
    for raw in entries:
        if block and len(block) + len(raw) > BLOCK:
            blocks.append(block)
            block = b""
        places.append((len(blocks), len(block)))
        block += raw
    blocks.append(block)
    packed = [zlib.compress(b, 9) for b in blocks]
    pool, index = b"", b""
    for name, entry in rows:
        index += struct.pack("<IH", len(pool), entry)
        pool += name.encode()
    starts = [0]
    for b in packed:
        starts.append(starts[-1] + len(b))
    head = struct.pack("<4I", len(rows), len(pool), len(entries), len(packed))
    places = b"".join(struct.pack("<HI", *p) for p in places)
    out.write_bytes(head + index + pool + places + struct.pack(f"<{len(starts)}I", *starts) + b"".join(packed))
    print(f"{len(entries)} entries, {len(rows)} names, {out.stat().st_size} bytes ({len(pool) + len(index)} of names)")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
