#!/usr/bin/env python3
"""Decode every brick of a .brick file, from docs/FORMAT.md alone. Standard library only, so codec none only
(`brick convert --codec none`). Usage: second_reader.py FILE.brick [OUT.raw]: checks the layout, compares every
brick's borders, ranges and masks with its voxels, and writes level 0 as raw little-endian voxels."""
import math
import struct
import sys

TYPES = {0: ("B", 1), 1: ("b", 1), 2: ("H", 2), 3: ("h", 2), 4: ("f", 4)}


class Wrong(Exception):
    pass


def need(ok, what):
    if not ok:
        raise Wrong(what)


def read_header(data):
    need(data[:8] == b"\x89BRK\r\n\x1a\n", "magic")
    version, header_bytes, file_bytes = struct.unpack_from("<IIQ", data, 8)
    need((version, header_bytes, file_bytes) == (1, 512, len(data)), "version or size")
    h = dict(zip(("type", "B", "P", "M", "levels", "channels", "times", "entry"), struct.unpack_from("<8I", data, 24)))
    h["dims"] = struct.unpack_from("<3Q", data, 56)
    h["tables"] = [struct.unpack_from("<3Q", data, 192 + 24 * t) for t in range(4)]
    need(h["type"] in TYPES and h["entry"] == 48 and (h["channels"], h["times"]) == (1, 1), "header")
    h["tolerance"] = struct.unpack_from("<d", data, 288)[0]
    need(0 <= h["tolerance"] < math.inf and data[296:504] == bytes(208), "reserved bytes")
    return h


def read_levels(data, h):
    at, size, _ = h["tables"][0]
    need(size == 104 * h["levels"], "level table")
    levels, first = [], 0
    for number in range(h["levels"]):
        numbers = struct.unpack_from("<7Q6d", data, at + 104 * number)
        level = {"dims": numbers[:3], "bricks": numbers[3:6], "first": numbers[6], "scale": numbers[7:10]}
        need(level["bricks"] == tuple(-(-n // h["B"]) for n in level["dims"]), "bricks of a level")
        need(level["first"] == first, "first brick of a level")
        first += math.prod(level["bricks"])
        levels.append(level)
    need(levels[0]["dims"] == h["dims"] and math.prod(levels[-1]["bricks"]) == 1, "levels")
    need(h["tables"][1][1] == 48 * first, "index size")
    return levels


def read_entry(data, h, number):
    names = ("offset", "bytes", "codec", "flags", "zero", "checksum", "min", "max", "mask", "value", "nonfinite")
    return dict(zip(names, struct.unpack_from("<QIBBHQffQII", data, h["tables"][1][0] + 48 * number)))


def decode(data, h, entry, stored, cells):
    """Voxels and macrocell pairs of one brick."""
    letter, width = TYPES[h["type"]]
    voxels, pairs = math.prod(stored), math.prod(cells)
    if entry["flags"] & 1:
        value = struct.unpack("<f", struct.pack("<I", entry["value"]))[0]
        kind = float if letter == "f" else int
        ends = [entry[end] if math.isinf(entry[end]) else kind(entry[end]) for end in ("min", "max")]
        return (kind(value),) * voxels, tuple(ends) * pairs
    need(entry["codec"] < 5 or h["tolerance"] > 0, "a lossy brick in a lossless file")
    need(entry["codec"] == 0, "codec %d: this reader decodes codec none only" % entry["codec"])
    need(entry["bytes"] == (voxels + 2 * pairs) * width, "payload size")
    numbers = struct.unpack_from("<%d%s" % (voxels + 2 * pairs, letter), data, entry["offset"])
    return numbers[:voxels], numbers[voxels:]


def finite_range(values):
    finite = [v for v in values if math.isfinite(v)]
    return (min(finite), max(finite)) if finite else (math.inf, -math.inf)


def check_ranges(h, entry, core, stored, cells, voxels, pairs, exact):
    """Macrocells and index against the voxels: equal at level 0, no narrower above it."""
    P, M, i = h["P"], h["M"], 0
    row = lambda x, y, z: ((z + P) * stored[1] + y + P) * stored[0] + x + P
    for mz in range(cells[2]):
        for my in range(cells[1]):
            for mx in range(cells[0]):
                end = [min(m * M + M, c) for m, c in zip((mx, my, mz), core)]
                own = finite_range([v for z in range(mz * M, end[2] + 1) for y in range(my * M, end[1] + 1)
                                    for v in voxels[row(mx * M, y, z):row(end[0], y, z) + 1]])
                said = (pairs[i], pairs[i + 1])
                need(own == said if exact else said[0] <= own[0] and said[1] >= own[1], "macrocell range")
                i += 2
    low, high = min(pairs[0::2]), max(pairs[1::2])
    need((low, high) == (entry["min"], entry["max"]), "brick range")
    if not (exact and low < high):
        return
    mask = 0
    bin_of = lambda v: min(63, int((v - low) * (64.0 / (high - low))))
    for z in range(core[2]):
        for y in range(core[1]):
            for x in range(core[0]):
                a, b = finite_range([voxels[row(x + i, y + j, z + k)]
                                     for i in (0, 1) for j in (0, 1) for k in (0, 1)])
                if a <= b:
                    mask |= (2 << bin_of(b)) - (1 << bin_of(a))
    need(mask == entry["mask"], "occupancy mask")


def same(a, b):
    return a == b or (a != a and b != b)


def main():
    data = open(sys.argv[1], "rb").read()
    h = read_header(data)
    letter, width = TYPES[h["type"]]
    levels = read_levels(data, h)
    decoded, payload_end = 0, 512
    raw = bytearray(math.prod(h["dims"]) * width)
    for number, level in enumerate(levels):
        bricks, dims, bricks_of = {}, level["dims"], level["bricks"]
        volume = {}
        for index in range(math.prod(bricks_of)):
            b = (index % bricks_of[0], index // bricks_of[0] % bricks_of[1], index // bricks_of[0] // bricks_of[1])
            entry = read_entry(data, h, level["first"] + index)
            if not entry["flags"] & 1:
                need(entry["offset"] == payload_end, "payloads have gaps")
                payload_end += entry["bytes"]
            core = [min(h["B"], n - a * h["B"]) for a, n in zip(b, dims)]
            stored, cells = [c + 2 * h["P"] for c in core], [-(-c // h["M"]) for c in core]
            voxels, pairs = decode(data, h, entry, stored, cells)
            check_ranges(h, entry, core, stored, cells, voxels, pairs, number == 0)
            bricks[b] = (core, stored, voxels)
            for z in range(core[2]):
                for y in range(core[1]):
                    at = ((z + h["P"]) * stored[1] + y + h["P"]) * stored[0] + h["P"]
                    line = voxels[at:at + core[0]]
                    where = (b[2] * h["B"] + z, b[1] * h["B"] + y)
                    volume.setdefault(where, {})[b[0]] = line
            decoded += 1
        lines = {w: sum((parts[i] for i in sorted(parts)), ()) for w, parts in volume.items()}
        clamp = lambda i, n: min(max(i, 0), n - 1)
        for b, (core, stored, voxels) in bricks.items():  # borders against the assembled level
            lo, at = [a * h["B"] - h["P"] for a in b], 0
            for z in range(stored[2]):
                for y in range(stored[1]):
                    line = lines[clamp(lo[2] + z, dims[2]), clamp(lo[1] + y, dims[1])]
                    for x in range(stored[0]):
                        need(same(voxels[at], line[clamp(lo[0] + x, dims[0])]), "border of brick %s" % (b,))
                        at += 1
        if number == 0:
            for (z, y), line in lines.items():
                struct.pack_into("<%d%s" % (dims[0], letter), raw, (z * dims[1] + y) * dims[0] * width, *line)
    need(payload_end == h["tables"][0][0], "payload end")
    if len(sys.argv) > 2:
        open(sys.argv[2], "wb").write(raw)
    print("%d bricks decoded" % decoded)


if __name__ == "__main__":
    try:
        main()
    except (Wrong, struct.error, OSError, IndexError) as error:
        sys.exit("second_reader: %s" % error)
