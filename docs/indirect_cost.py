#!/usr/bin/env python3
"""How cached transport's memory and both methods' times grow, into a table of docs/indirect.md.

    python3 docs/indirect_cost.py [--isolux PATH] [--turns N] [--write]

Times are of whole pictures less the same pictures without indirect light, in processor seconds, as
ratios to the first row of each group; the group's rows take turns, and the medians stand. Memory is
what `isolux render` says. Standard library only; ten minutes.
"""

import argparse
import re
import resource
import statistics
import subprocess
import tempfile
from pathlib import Path

from page_table import write_table

DOCS = Path(__file__).resolve().parent
BEGIN, END = "<!-- table: docs/indirect_cost.py --write -->\n", "<!-- end of costs -->\n"
LAMPS = ["point,at=-300:-500:300", "point,at=300:-400:100", "directional,to=1:-0.3:0.5",
         "point,at=0:-500:-200"]
METHODS = {"transport": ["--indirect", "transport"],
           "path": ["--indirect", "path", "--spp", "16"]}


def case(voxels=128, pixels=512, bounces=2, lamps=1):
    """Words of `isolux render`, and of its indirect light: a head phantom whose box does not grow
    with its voxels."""
    words = [f"phantom:head,size={voxels}", "--surface", "iso=300", "--size", f"{pixels}x{pixels}",
             "--shadows", "on"]
    words += [word for lamp in LAMPS[:lamps] for word in ("--light", lamp)]
    return words, ["--bounces", str(bounces)]


GROUPS = {
    "voxels": {f"{n}³": case(voxels=n) for n in (64, 128, 256)},
    "pixels": {f"{n}²": case(pixels=n) for n in (256, 512, 1024)},
    "bounces": {str(n): case(bounces=n) for n in (1, 2, 4)},
    "lamps": {str(n): case(lamps=n) for n in (1, 2, 4)},
}


def drawn(isolux, folder, words):
    """Processor seconds, and the megabytes that transport told."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([isolux, "render", *words, "-o", Path(folder) / "a.png"], check=True,
                          capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = re.search(r"links a sample, ([\d.]+) MB", done.stderr)
    return (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
            float(told[1]) if told else 0)


def group_rows(isolux, folder, what, cases, turns):
    seconds = {name: {method: [] for method in METHODS} for name in cases}
    megabytes = {}
    for _ in range(turns):
        for name, (words, bounces) in cases.items():
            without, _ = drawn(isolux, folder, words)
            for method, times in seconds[name].items():
                with_it, told = drawn(isolux, folder, [*words, *METHODS[method], *bounces])
                times.append(with_it - without)
                megabytes[name] = told or megabytes.get(name)
    medians = {name: {method: statistics.median(times) for method, times in by.items()}
               for name, by in seconds.items()}
    first = next(iter(medians.values()))
    for name, by in medians.items():
        yield (f"| {what} | {name} | {megabytes[name]:.0f} MB | "
               f"{by['transport'] / first['transport']:.1f} | {by['path'] / first['path']:.1f} |\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--turns", type=int, default=3, help="(%(default)s)")
    parser.add_argument("--write", action="store_true", help="write it into docs/indirect.md")
    arguments = parser.parse_args()
    lines = ["| what grows | to | transport's memory | transport, links and all | paths, 16 a pixel |\n", "| --- | ---: | ---: | ---: | ---: |\n"]
    with tempfile.TemporaryDirectory() as folder:
        for what, cases in GROUPS.items():
            lines += group_rows(arguments.isolux, folder, what, cases, arguments.turns)
    print("".join(lines), end="")
    if arguments.write:
        write_table(DOCS / "indirect.md", BEGIN, END, lines)


if __name__ == "__main__":
    main()
