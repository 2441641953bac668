#!/usr/bin/env python3
"""Holds cached transport against the path tracer, and writes the table of docs/indirect.md.

    python3 docs/indirect_table.py [--isolux PATH] [--size N] [--spp N] [--write]

For each surface and lamp the same picture is drawn by both. The judge is noisy itself: two of its
pictures, of other random numbers, tell by how much, and each number stands beside that noise. --write
puts the table into docs/indirect.md. Standard library only; a quarter of an hour.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests/cli"))
from page_table import write_table  # noqa: E402
from pictures import read_exr  # noqa: E402

BEGIN, END = "<!-- table: docs/indirect_table.py --write -->\n", "<!-- end of table -->\n"
SURFACES = {"skull": "iso=300", "skin": "iso=-300"}
LAMPS = {
    "before the face, high": "point,at=-120:-560:260",
    "at the left side": "point,at=420:-120:80",
    "above": "point,at=120:-120:500",
    "inside the skull": "point,at=120:-120:80",
    "grazing": "directional,to=1:0.3:0.05",
}
CAMERA = "eye=-60:-620:190,target=118:-140:80,fov=24"


def indirect(isolux, folder, surface, lamp, size, *method):
    """The green channel of the indirect term, of pixels that show a surface."""
    path = folder / "a.exr"
    subprocess.run([isolux, "render", "--size", f"{size}x{size}", "--surface", surface, "--light",
                    lamp, "--shadows", "on", "--camera", CAMERA, "-o", path, "--indirect", *method],
                   check=True, stderr=subprocess.DEVNULL)
    exr = read_exr(path)
    return [exr.at("indirect.G", x, y) for y in range(size) for x in range(size)
            if exr.at("surface.id", x, y) >= 0]


def row(isolux, folder, surface, lamp, size, spp):
    def judged(seed):
        return indirect(isolux, folder, surface, lamp, size, "path", "--spp", str(spp), "--seed",
                        str(seed))

    one, other = judged(1), judged(2)
    found = indirect(isolux, folder, surface, lamp, size, "transport")
    truth = [(a + b) / 2 for a, b in zip(one, other)]
    mean = sum(truth) / len(truth)
    off = sorted(abs(a - b) for a, b in zip(found, truth))
    noise = sum(abs(a - b) for a, b in zip(one, other)) / len(truth) / 2
    bias = sum(a - b for a, b in zip(found, truth)) / len(truth)
    return (f"{mean:.3f} | {bias / mean:+.1%} | {sum(off) / len(off) / mean:.1%} | "
            f"{noise / mean:.1%} | {off[int(0.99 * len(off))] / mean:.0%}").replace("%", " %")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--size", type=int, default=192, help="pixels a side (%(default)s)")
    parser.add_argument("--spp", type=int, default=4096, help="paths a pixel (%(default)s)")
    parser.add_argument("--write", action="store_true", help="write it into docs/indirect.md")
    arguments = parser.parse_args()
    lines = ["| surface | lamp | mean of kd E | bias | mean error | the judge's own noise | "
             "99th percentile |\n", "| --- | --- | ---: | ---: | ---: | ---: | ---: |\n"]
    with tempfile.TemporaryDirectory() as name:
        for surface, option in SURFACES.items():
            for lamp, light in LAMPS.items():
                numbers = row(arguments.isolux, Path(name), option, light, arguments.size,
                              arguments.spp)
                lines.append(f"| {surface} | {lamp} | {numbers} |\n")
                print(lines[-1], end="", flush=True)
    if arguments.write:
        write_table(DOCS / "indirect.md", BEGIN, END, lines)


if __name__ == "__main__":
    main()
