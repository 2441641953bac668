#!/usr/bin/env python3
"""Draws a scene by cached transport and by paths, and beside them what they differ by.

    python3 docs/side_by_side.py skull|box [--isolux PATH] [--size N] [--spp N] -o OUT.png

Left transport, in the middle the path tracer, right 8 times their difference in displayed steps:
middle grey where there is none, lighter where transport is. Exits with 77 where the scan or the mesh
is not on this machine. Standard library only.
"""

import argparse
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

sys.dont_write_bytecode = True
DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests/cli"))
from indirect_scenes import BOX, scenes  # noqa: E402
from pictures import png_bytes, read_png  # noqa: E402

TIMES = 8
GREY = 128
NAMES = {"skull": "skull", "box": "Cornell box"}


def has_scan(isolux):
    return "phantom" not in subprocess.run([isolux, "info"], capture_output=True, text=True).stdout


def drawn(isolux, folder, scene, size, *method):
    path = folder / "a.png"
    subprocess.run([isolux, "render", *scenes()[scene], "--size", f"{size}x{size}", "--shadows",
                    "on", "-o", path, "--indirect", *method], check=True,
                   stderr=subprocess.DEVNULL)
    return read_png(path).rows


def difference(row, other):
    return bytes(max(0, min(255, GREY + TIMES * (a - b))) for a, b in zip(row, other))


def write_png(path, rows):
    head = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows), 9)
    path.write_bytes(png_bytes([(b"IHDR", head), (b"IDAT", data), (b"IEND", b"")]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("scene", choices=NAMES)
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--size", type=int, default=300, help="pixels a side (%(default)s)")
    parser.add_argument("--spp", type=int, default=256, help="paths a pixel (%(default)s)")
    parser.add_argument("-o", dest="out", required=True, help="the picture")
    asked = parser.parse_args()
    if not (BOX.exists() if asked.scene == "box" else has_scan(asked.isolux)):
        print(f"skipped: the {NAMES[asked.scene]} is not on this machine")
        return 77
    with tempfile.TemporaryDirectory() as name:
        def by(*method):
            return drawn(asked.isolux, Path(name), NAMES[asked.scene], asked.size, *method)

        transport, paths = by("transport"), by("path", "--spp", str(asked.spp))
    write_png(Path(asked.out), [a + b + difference(a, b) for a, b in zip(transport, paths)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
