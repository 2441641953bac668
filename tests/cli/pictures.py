"""Reads the pictures that isolux writes (PNG, EXR) and writes small volumes (NRRD)."""

import gzip
import itertools
import struct
import zlib
from pathlib import Path


class Png:
    """width, height, rows of RGB bytes, texts (iTXt) and chunks (type, data)."""

    def __init__(self, width, height, rows, texts, chunks):
        self.width, self.height, self.rows = width, height, rows
        self.texts, self.chunks = texts, chunks

    def at(self, x, y):
        return tuple(self.rows[y][3 * x:3 * x + 3])


def png_chunks(data):
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG")
    chunks, at = [], 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if struct.unpack_from(">I", data, at + 8 + length)[0] != zlib.crc32(kind + body):
            raise ValueError(f"wrong checksum of {kind}")
        chunks.append((kind, body))
        at += 12 + length
    return chunks


def png_bytes(chunks):
    """The inverse of png_chunks."""
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks)


def _itxt(body):
    key, rest = body.split(b"\0", 1)
    compressed, rest = rest[0], rest[2:]
    text = rest.split(b"\0", 2)[2]  # past the language and the translated key
    return key.decode("latin-1"), (zlib.decompress(text) if compressed else text).decode()


def _unfiltered(kind, line, above, step):
    line = bytearray(line)
    for i in range(len(line)):
        a = line[i - step] if i >= step else 0
        b = above[i]
        c = above[i - step] if i >= step else 0
        if kind == 1:
            add = a
        elif kind == 2:
            add = b
        elif kind == 3:
            add = (a + b) // 2
        else:  # Paeth
            p = a + b - c
            add = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        line[i] = (line[i] + add) & 255
    return bytes(line)


def read_png(path):
    """8-bit RGB without interlacing, which is what isolux writes."""
    chunks = png_chunks(Path(path).read_bytes())
    width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[0][1])
    if (depth, color, interlaced) != (8, 2, 0):
        raise ValueError("not plain 8-bit RGB")
    data = zlib.decompress(b"".join(body for kind, body in chunks if kind == b"IDAT"))
    rows, above = [], bytes(3 * width)
    for y in range(height):
        begin = y * (3 * width + 1)
        line = data[begin + 1:begin + 1 + 3 * width]
        above = line if data[begin] == 0 else _unfiltered(data[begin], line, above, 3)
        rows.append(above)
    texts = dict(_itxt(body) for kind, body in chunks if kind == b"iTXt")
    return Png(width, height, rows, texts, chunks)


class Exr:
    """width, height, attributes {name: (type, bytes)}, channels {name: floats, row by row}."""

    def __init__(self, width, height, attributes, channels):
        self.width, self.height = width, height
        self.attributes, self.channels = attributes, channels
        self.texts = {n: v.decode() for n, (kind, v) in attributes.items() if kind == "string"}

    def at(self, name, x, y):
        return self.channels[name][y * self.width + x]

    def triple(self, layer, x, y):
        """A layer's three numbers: "diffuse" (R, G, B), "normal" (X, Y, Z), "" (the radiance)."""
        letters = "XYZ" if layer in ("normal", "position") else "RGB"
        return tuple(self.at(f"{layer}.{c}" if layer else c, x, y) for c in letters)

    def pixels(self):
        return itertools.product(range(self.width), range(self.height))

    def hits(self):
        return [(x, y) for x, y in self.pixels() if self.at("surface.id", x, y) >= 0]


def _zero_terminated(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _unzipped(data, size):
    if len(data) == size:  # a block that would not shrink is stored as it is
        return data
    deltas = zlib.decompress(data)
    # Each byte is the difference from the one before, plus 128; the even bytes come first.
    whole = bytes((total - 128 * n) & 255
                  for n, total in enumerate(itertools.accumulate(deltas)))
    half = (size + 1) // 2
    out = bytearray(size)
    out[0::2], out[1::2] = whole[:half], whole[half:]
    return bytes(out)


def read_exr(path):
    """One part, scan lines, 32-bit float channels, no or ZIP/ZIPS compression."""
    data = Path(path).read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630 or version & 0xff != 2 or version & ~0x4ff:  # bit 10: long names
        raise ValueError("no one-part scan-line EXR")
    attributes, at = {}, 8
    while data[at]:
        name, at = _zero_terminated(data, at)
        kind, at = _zero_terminated(data, at)
        (size,) = struct.unpack_from("<I", data, at)
        attributes[name] = (kind, data[at + 4:at + 4 + size])
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    compression = attributes["compression"][1][0]
    lines_a_block = {0: 1, 2: 1, 3: 16}[compression]

    names, listing, here = [], attributes["channels"][1], 0
    while listing[here]:
        name, here = _zero_terminated(listing, here)
        if struct.unpack_from("<i", listing, here) != (2,):
            raise ValueError(f"channel {name} is not 32-bit float")
        names.append(name)
        here += 16

    channels = {name: [None] * (width * height) for name in names}
    blocks = -(-height // lines_a_block)
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        first, size = struct.unpack_from("<iI", data, offset)
        lines = min(lines_a_block, y1 + 1 - first)
        block = data[offset + 8:offset + 8 + size]
        if compression:
            block = _unzipped(block, 4 * width * lines * len(names))
        values = struct.unpack(f"<{width * lines * len(names)}f", block)
        for n, (line, name) in enumerate(itertools.product(range(lines), names)):
            begin = (first - y0 + line) * width
            channels[name][begin:begin + width] = values[n * width:(n + 1) * width]
    return Exr(width, height, attributes, channels)


# type: how NRRD and `--type` name it, and Python's letter
TYPES = {"u8": ("uint8", "B"), "i16": ("int16", "h"), "u16": ("uint16", "H"), "f32": ("float", "f"),
         "f64": ("double", "d")}


def voxel_bytes(values, kind, big_endian=False):
    return struct.pack((">" if big_endian else "<") + str(len(values)) + TYPES[kind][1], *values)


def grid(dims, value):
    """The values of value(i, j, k) in file order, i fastest."""
    return [value(i, j, k)
            for k in range(dims[2]) for j in range(dims[1]) for i in range(dims[0])]


def write_nrrd(path, dims, values, kind="i16", *, encoding="raw", big_endian=False,
               directions=None, origin=(0, 0, 0), space="left-posterior-superior", data_file=None,
               fields=()):
    """A NRRD file; `directions` holds the step of i, of j and of k. With `data_file` a header and
    its data beside it; a %d pattern such as "slice.%03d 1 9 1" makes one file for each k."""
    path = Path(path)
    vector = lambda v: "(" + ",".join(repr(float(x)) for x in v) + ")"
    lines = ["NRRD0004", f"type: {TYPES[kind][0]}", "dimension: 3",
             "sizes: " + " ".join(map(str, dims)), f"encoding: {encoding}"]
    if TYPES[kind][1] != "B":
        lines.append("endian: " + ("big" if big_endian else "little"))
    if directions:
        lines += [f"space: {space}", "space directions: " + " ".join(map(vector, directions)),
                  "space origin: " + vector(origin)]
    lines += list(fields)
    data = voxel_bytes(values, kind, big_endian)
    packed = {"raw": bytes, "gzip": gzip.compress}[encoding]
    if data_file is None:
        path.write_bytes("\n".join(lines).encode() + b"\n\n" + packed(data))
        return path
    path.write_text("\n".join([*lines, f"data file: {data_file}"]) + "\n")
    if "%" in data_file:
        pattern, first, _, step = data_file.split()
        size = len(data) // dims[2]
        for k in range(dims[2]):
            part = data[k * size:(k + 1) * size]
            (path.parent / (pattern % (int(first) + k * int(step)))).write_bytes(packed(part))
    else:
        (path.parent / data_file).write_bytes(packed(data))
    return path


def blob(i, j, k):
    """A lopsided body on 17 x 15 x 13 voxels, -1000 outside to about 900 inside: no turn, swap or
    mirroring of the axes carries it into itself. Surfaces at 0."""
    def ball(x, y, z, radius):
        return radius - ((i - x) ** 2 + (j - y) ** 2 + 1.3 * (k - z) ** 2) ** 0.5
    inside = max(ball(8, 7, 6, 4.6), ball(12.5, 6, 7.5, 2.3), ball(7, 2.5, 8, 2.1),
                 ball(6, 8, 10, 2))
    return max(-1000, round(200 * inside))


BLOB_DIMS = (17, 15, 13)
