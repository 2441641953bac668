#!/usr/bin/env python3
"""Looks for light that cached transport lets through bone: the inside of the CT skull, lit from outside.

    python3 docs/indirect_leaks.py [--isolux PATH] [--size N] [--spp N] [--write]

From the middle of the braincase six views see all of its inside. Of the pixels that no lamp lights
itself and that see nearly no sky it lists the ten brightest by transport, by the path tracer, and
from where `isolux explain` finds their light to come; and the blocks of 8 x 8 pixels in which
transport brings most more than paths do, which finds leaks that are not the brightest. --write
puts the tables into docs/decisions/0038-proof-of-transport.md. Standard library only; some minutes.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests/cli"))
from page_table import write_table  # noqa: E402
from pictures import read_exr  # noqa: E402

BEGIN, END = "<!-- table: docs/indirect_leaks.py --write -->\n", "<!-- end of leaks -->\n"
MIDDLE = (118, -115, 95)
VIEWS = {"face": (0, -1, 0), "back": (0, 1, 0), "left": (1, 0, 0), "right": (-1, 0, 0),
         "top": (0, 0, 1), "base": (0, 0, -1)}
LAMPS = {"at the left side": "point,at=420:-120:80", "behind": "point,at=118:420:120",
         "above": "point,at=120:-120:500"}
BLOCK = 8
MOST_SKY = 0.05  # what sees more of it is in an opening, not inside
APART_MM = 5     # of two bright pixels that lie closer the brighter one is listed


def words_of(view, lamp, size):
    target = ":".join(str(m + 10 * d) for m, d in zip(MIDDLE, VIEWS[view]))
    up = "0:-1:0" if VIEWS[view][2] else "0:0:1"
    eye = ":".join(map(str, MIDDLE))
    return ["--size", f"{size}x{size}", "--surface", "iso=300", "--light", LAMPS[lamp],
            "--shadows", "on", "--camera", f"eye={eye},target={target},up={up},fov=90"]


class Look:
    """One view by transport and, with other random numbers, twice by few paths."""

    def __init__(self, isolux, folder, view, lamp, size, spp):
        self.isolux, self.words = isolux, words_of(view, lamp, size)
        self.view, self.lamp, self.size = view, lamp, size

        def drawn(*method):
            subprocess.run([isolux, "render", *self.words, "-o", folder / "a.exr", "--indirect",
                            *method], check=True, stderr=subprocess.DEVNULL)
            return read_exr(folder / "a.exr")

        self.transport = drawn("transport")
        self.paths = [drawn("path", "--spp", str(spp), "--seed", str(seed)) for seed in (1, 2)]

    def inside(self):
        """The pixels inside the skull that the lamp does not light itself."""
        return [(x, y) for x, y in self.transport.hits()
                if self.transport.at("diffuse.G", x, y) == 0
                and self.paths[0].at("sky.Y", x, y) <= MOST_SKY]

    def explained(self, x, y, spp, seed):
        told = subprocess.run([self.isolux, "explain", *self.words, "--pixel", f"{x},{y}", "--json",
                               "--indirect", "path", "--spp", str(spp), "--seed", str(seed)],
                              check=True, capture_output=True, text=True)
        return json.loads(told.stdout)


def place(p):
    return "({:.0f}, {:.0f}, {:.0f})".format(*p)


def brightest(looks, count):
    """(indirect light, look, x, y) of the brightest pixels, none within APART_MM of another."""
    all_of_them = sorted(((look.transport.at("indirect.G", x, y), look, x, y)
                          for look in looks for x, y in look.inside()),
                         key=lambda one: -one[0])
    taken = []
    for one in all_of_them:
        at = one[1].transport.triple("position", *one[2:])
        if all(math.dist(at, look.transport.triple("position", x, y)) > APART_MM
               for _, look, x, y in taken):
            taken.append(one)
        if len(taken) == count:
            return taken
    return taken


def told_senders(explained):
    """The share of the first bounce, and the two brightest places that send it."""
    bounces = [part[1] for part in explained["bounces"]]
    first = explained["first_bounce"]["senders"]
    share = f"{bounces[0] / sum(bounces):.0%}".replace("%", " %") if sum(bounces) > 0 else "–"
    places = "; ".join(
        f"{sender['share']:.0%} from {place(sender['position'])}, "
        f"{math.dist(sender['position'], explained['position']):.0f} mm".replace("%", " %")
        for sender in first[:2])
    return share, places or "nothing: no lit place is in sight"


def bright_rows(looks, spp):
    for light, look, x, y in brightest(looks, 10):
        one, other = (look.explained(x, y, spp, seed) for seed in (1, 2))
        paths = [e["indirect"][1] for e in (one, other)]
        mean, noise = sum(paths) / 2, abs(paths[0] - paths[1]) / 2
        more = f"{light / mean - 1:+.0%}".replace("%", " %") if mean > 0 else "all of it"
        share, places = told_senders(one)
        yield (f"| {look.lamp} | {look.view} {x}, {y} | {place(one['position'])} | {light:.4f} | "
               f"{mean:.4f} ± {noise:.4f} | {more} | {share} | {places} |\n")


def blocks(looks):
    """(excess, noise, light by paths, pixels, look, x, y) of each block, per pixel."""
    for look in looks:
        pixels = {}
        for x, y in look.inside():
            pixels.setdefault((x // BLOCK * BLOCK, y // BLOCK * BLOCK), []).append((x, y))
        for (left, top), members in pixels.items():
            if len(members) < BLOCK * BLOCK / 2:
                continue
            by = [sum(exr.at("indirect.G", x, y) for x, y in members) / len(members)
                  for exr in (look.transport, *look.paths)]
            path = (by[1] + by[2]) / 2
            yield by[0] - path, abs(by[1] - by[2]) / 2, path, members, look, left, top


def block_rows(looks):
    for excess, noise, path, members, look, left, top in sorted(
            blocks(looks), key=lambda one: -one[0])[:5]:
        x, y = members[len(members) // 2]
        at = place(look.transport.triple("position", x, y))
        yield (f"| {look.lamp} | {look.view} {left}, {top} | {at} | {path + excess:.5f} | "
               f"{path:.5f} ± {noise:.5f} | {excess:+.5f} |\n")


def whole_row(looks):
    """Of all blocks together: means by both, and how evenly they differ."""
    found = list(blocks(looks))
    count = sum(len(one[3]) for one in found)
    path = sum(one[2] * len(one[3]) for one in found) / count
    excess = sum(one[0] * len(one[3]) for one in found) / count
    off = sum(abs(one[0]) * len(one[3]) for one in found) / count
    noise = sum(one[1] * len(one[3]) for one in found) / count
    return (f"| {looks[0].lamp} | {count} | {path:.5f} | {path + excess:.5f} | "
            f"{excess / path:+.1%} | {off / path:.1%} | {noise / path:.1%} |\n".replace("%", " %"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--size", type=int, default=128, help="pixels a side (%(default)s)")
    parser.add_argument("--spp", type=int, default=64,
                        help="paths a pixel; of those listed 256 times as many (%(default)s)")
    parser.add_argument("--write", action="store_true", help="write them into the decision")
    arguments = parser.parse_args()
    whole = ["| lamp | pixels | mean by paths | by transport | bias | mean difference of blocks | "
             "paths' noise |\n", "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n"]
    bright = ["| lamp | pixel | at, mm | transport | paths | more | first bounce | who sends it |\n",
              "| --- | --- | --- | ---: | ---: | ---: | ---: | --- |\n"]
    excess = ["| lamp | block | at, mm | transport | paths | more |\n",
              "| --- | --- | --- | ---: | ---: | ---: |\n"]
    with tempfile.TemporaryDirectory() as name:
        for lamp in LAMPS:
            looks = [Look(arguments.isolux, Path(name), view, lamp, arguments.size, arguments.spp)
                     for view in VIEWS]
            whole.append(whole_row(looks))
            excess += block_rows(looks)
            bright += bright_rows(looks, 256 * arguments.spp)
    lines = [*whole, "\n", *bright, "\n", *excess]
    print("".join(lines), end="")
    if arguments.write:
        write_table(DOCS / "decisions/0038-proof-of-transport.md", BEGIN, END, lines)


if __name__ == "__main__":
    main()
