#!/usr/bin/env python3
"""How far pictures of few paths a pixel are from a converged one, with and without the denoiser.

    python3 docs/denoise_table.py [--isolux PATH] [--size N] [--spp N] [--box cornell_box.obj]
                                  [--keep DIR] [--write]

Each number is the mean of FLIP over the pixels that show a surface (flip.py). --write puts the table
into docs/indirect.md. Needs numpy; ten minutes.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

sys.dont_write_bytecode = True
DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests/cli"))
from flip import flip  # noqa: E402
from indirect_scenes import BOX, scenes  # noqa: E402
from page_table import write_table  # noqa: E402
from pictures import read_png  # noqa: E402

BEGIN, END = "<!-- table: docs/denoise_table.py --write -->\n", "<!-- end of FLIP -->\n"


def drawn(isolux, path, size, words):
    subprocess.run([isolux, "render", "--size", f"{size}x{size}", "--shadows", "on", *words, "-o",
                    path], check=True, stderr=subprocess.DEVNULL)
    png = read_png(path)
    return numpy.array([list(row) for row in png.rows]).reshape(size, size, 3) / 255


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--size", type=int, default=512, help="pixels a side (%(default)s)")
    parser.add_argument("--spp", type=int, default=1024, help="paths of the judge (%(default)s)")
    parser.add_argument("--box", default=BOX, help="the Cornell box (%(default)s)")
    parser.add_argument("--keep", metavar="DIR", help="keep the pictures there")
    parser.add_argument("--write", action="store_true", help="write it into docs/indirect.md")
    arguments = parser.parse_args()
    lines = ["| scene | paths a pixel | as they are | denoised |\n",
             "| --- | ---: | ---: | ---: |\n"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(arguments.keep or name)
        folder.mkdir(exist_ok=True)
        for scene, words in scenes(arguments.box).items():
            def picture(file, *more):
                return drawn(arguments.isolux, folder / f"{scene.split()[0]}_{file}.png",
                             arguments.size, [*words, *more])

            judge = picture("judge", "--indirect", "path", "--spp", str(arguments.spp), "--seed",
                            "1")
            before_black, before_white = (
                picture("shown", "--ambient", "0:0:0", "--background", background)
                for background in ("0:0:0", "9:9:9"))
            shown = (before_black == before_white).all(axis=2)
            for spp in (1, 4, 16):
                paths = ["--indirect", "path", "--spp", str(spp)]
                off, on = (flip(picture(f"{spp}_{n}", *paths, "--denoise", n), judge)[shown].mean()
                           for n in ("off", "on"))
                lines.append(f"| {scene} | {spp} | {off:.3f} | {on:.3f} |\n")
                print(lines[-1], end="", flush=True)
    if arguments.write:
        write_table(DOCS / "indirect.md", BEGIN, END, lines)


if __name__ == "__main__":
    main()
