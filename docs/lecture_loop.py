#!/usr/bin/env python3
"""The lecture's loop over the CT head, and whether isolux computes the same bytes.

For each voxel column (i, k), seen from the front: walk along j from the face inwards, find the
first crossing of the iso value by linear interpolation, light it, write a byte. All in index
units, as in the lecture: L = (0 - i, 0 - j, 57 - k). isolux renders the same columns with
--spacing 1:1:1 --display raw. Then n.l once more at the same points with the true spacing.

    python3 docs/lecture_loop.py [--isolux PATH]

Exit status: 0 the bytes agree (at most TOLERATED of them one apart, by rounding), 1 they do not,
77 the scan is not here. Standard library only.
"""

import argparse
import array
import os
import plistlib
import struct
import subprocess
import sys
import tarfile
import tempfile
import zlib
from math import floor, sqrt
from pathlib import Path

ISO, LAMP = 300, (0, 0, 57)
KA, KD, KS, SHININESS = 0.1, 0.8, 0.3, 40  # isolux's own defaults
TOLERATED = 3  # isolux keeps normals as floats: a sum within 1e-5 of a half may round either way
COMMAND = ["render", "--spacing", "1:1:1", "--display", "raw",
           "--surface", f"iso={ISO}",
           "--light", "point,at=%d:%d:%d,space=index" % LAMP,
           "--camera", "view=front,projection=orthographic,height={rows}",
           "--size", "{columns}x{rows}"]


def find_scan():
    """Where isolux looks too: Debian's package, then the cache."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.environ.get("HOME", ""), ".cache")
    for path in (Path("/usr/share/doc/invesalius-examples/examples/Cranium.inv3"),
                 Path(cache) / "isolux" / "Cranium.inv3"):
        if path.is_file():
            return path
    return None


def read_scan(path):
    """(voxels, (ni, nj, nk), spacing) of an InVesalius project, i running fastest."""
    with tarfile.open(path) as project:
        files = {Path(member.name).name: member for member in project}
        main = plistlib.loads(project.extractfile(files["main.plist"]).read())
        matrix = main["matrix"]
        voxels = array.array("h", project.extractfile(files[matrix["filename"]]).read())
    if sys.byteorder == "big":
        voxels.byteswap()
    nk, nj, ni = matrix["shape"]
    return voxels, (ni, nj, nk), main["spacing"]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    length = sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


class Head:
    def __init__(self, voxels, dims):
        self.voxels, self.dims = voxels, dims
        self.steps = (1, dims[0], dims[0] * dims[1])

    def first_crossing(self, i, k):
        """The j, not whole as a rule, where the column first meets the iso value; or None."""
        ni, nj, _ = self.dims
        start = i + ni * nj * k
        column = self.voxels[start:start + ni * nj:ni]
        for j in range(nj - 1, 0, -1):  # the cell between j and j - 1
            here, next_ = column[j] - ISO, column[j - 1] - ISO
            if here * next_ <= 0:
                return float(j) if here == 0 else j - here / (here - next_)
        return None

    def difference(self, voxel):
        """Central differences at a voxel, one-sided at the border, per voxel step."""
        at = sum(step * index for step, index in zip(self.steps, voxel))
        result = []
        for index, count, step in zip(voxel, self.dims, self.steps):
            low, high = min(index, 1), min(count - 1 - index, 1)
            result.append((self.voxels[at + high * step] - self.voxels[at - low * step])
                          / (high + low))
        return result

    def gradient(self, i, j, k):
        """Their trilinear blend; i and k are whole, so it is linear along j."""
        low = min(int(j), self.dims[1] - 2)
        w = j - low
        return [(1 - w) * a + w * b for a, b in
                zip(self.difference((i, low, k)), self.difference((i, low + 1, k)))]


def lit(gradient, to_lamp, to_eye):
    """The byte of the lecture's sum, and n.l. Lighting is two-sided."""
    n, l = unit([-g for g in gradient]), unit(to_lamp)
    if dot(n, to_eye) < 0:
        n = [-x for x in n]
    n_l = dot(n, l)
    intensity = KA
    if n_l > 0:
        r = [2 * n_l * a - b for a, b in zip(n, l)]
        intensity += KD * n_l + KS * max(0, dot(r, to_eye)) ** SHININESS
    return floor(255 * min(1, max(0, intensity)) + 0.5), n_l


def lecture_loop(head, spacing):
    """Rows of bytes from the top (k falling), and (n.l in index units, n.l in mm) of each hit."""
    ni, _, nk = head.dims
    rows, cosines = [], []
    for k in range(nk - 1, -1, -1):
        row = []
        for i in range(ni):
            j = head.first_crossing(i, k)
            if j is None:
                row.append(0)
                continue
            gradient = head.gradient(i, j, k)
            to_lamp = (LAMP[0] - i, LAMP[1] - j, LAMP[2] - k)
            byte, n_l = lit(gradient, to_lamp, (0, 1, 0))
            row.append(byte)
            # In mm a step along an axis is longer by the spacing, and a slope per step is less.
            _, n_l_mm = lit([g / s for g, s in zip(gradient, spacing)],
                            [d * s for d, s in zip(to_lamp, spacing)], (0, 1, 0))
            cosines.append((n_l, n_l_mm))
        rows.append(row)
    return rows, cosines


def read_png(data):
    """(width, height, rows of RGB bytes) of an 8-bit RGB PNG."""
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height = struct.unpack_from(">II", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride, rows = zlib.decompress(packed), 3 * width, []
    above = bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:][:stride])
        for x in range(stride):
            a, b, c = row[x - 3] if x > 2 else 0, above[x], above[x - 3] if x > 2 else 0
            distances = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            paeth = (a, b, c)[distances.index(min(distances))]
            row[x] = row[x] + (0, a, b, (a + b) // 2, paeth)[kind] & 255
        rows.append(row)
        above = row
    return width, height, rows


def rendered(isolux, dims):
    words = [word.format(columns=dims[0], rows=dims[2]) for word in COMMAND]
    print("isolux", *words, "-o loop.png", flush=True)
    with tempfile.TemporaryDirectory(prefix="isolux-loop-") as folder:
        subprocess.run([isolux, *words, "-o", "loop.png"], cwd=folder, check=True)
        width, height, rows = read_png((Path(folder) / "loop.png").read_bytes())
    assert (width, height) == (dims[0], dims[2])
    assert all(row[0::3] == row[1::3] == row[2::3] for row in rows)
    return [list(row[0::3]) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    default = Path(__file__).resolve().parents[1] / "build/release/isolux"
    parser.add_argument("--isolux", default=str(default), help="the program (default: %(default)s)")
    isolux = str(Path(parser.parse_args().isolux).resolve())
    scan = find_scan()
    if scan is None:
        print("skipped: the CT head (Debian's package invesalius-examples) is not on this machine")
        return 77
    voxels, dims, spacing = read_scan(scan)
    loop, cosines = lecture_loop(Head(voxels, dims), spacing)
    picture = rendered(isolux, dims)

    apart = [(abs(a - b), x, y, a, b) for y, rows in enumerate(zip(loop, picture))
             for x, (a, b) in enumerate(zip(*rows)) if a != b]
    print(f"{dims[0]} x {dims[2]} columns, {len(cosines)} of them meet bone, "
          f"{sum(before > 0 for before, _ in cosines)} of these face the lamp")
    print(f"bytes that differ: {len(apart)}, of these by more than 1: "
          f"{sum(step > 1 for step, *_ in apart)}")
    for _, x, y, a, b in sorted(apart, reverse=True)[:8]:
        print(f"  pixel ({x}, {y}), voxel column i = {x}, k = {dims[2] - 1 - y}: "
              f"the loop says {a}, isolux {b}")
    print("n.l with the true spacing of %g x %g x %g mm:" % tuple(spacing))
    for which, these in (("all that meet bone", cosines),
                         ("those that face the lamp", [c for c in cosines if c[0] > 0])):
        change = [abs(after - before) for before, after in these]
        print("  %s: mean change %.4f, largest %.4f"
              % (which, sum(change) / len(change), max(change)))
    crossed = sum((before > 0) != (after > 0) for before, after in cosines)
    print(f"pixels that turn from lit to unlit or back: {crossed}")
    return 0 if len(apart) <= TOLERATED and all(step == 1 for step, *_ in apart) else 1


if __name__ == "__main__":
    sys.exit(main())
