#!/usr/bin/env python3
"""Times rays against rasterisation on meshes, and writes the table of docs/meshes.md.

    python3 docs/mesh_table.py [--isolux PATH] [--frames N] [--write] [MESH...]

Balls of more and more triangles, the skull of the example head, all of which isolux extracts, and
each MESH. Both ways take turns, frame by frame (`isolux bench`), so that a busy machine slows both.
--write puts the table into docs/meshes.md. Standard library only.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from page_table import write_table

DOCS = Path(__file__).resolve().parent
BEGIN, END = "<!-- table: docs/mesh_table.py --write -->\n", "<!-- end of table -->\n"
# A ball's voxels along a side, which make about 8 n^2 / 3 triangles.
BALLS = (9, 33, 129)
SIZES = (256, 1024, 2048)


def made_meshes(isolux, folder):
    def extracted(name, source, iso):
        path = folder / f"{name}.ply"
        subprocess.run([isolux, "mesh", source, path, "--iso", iso], check=True,
                       stderr=subprocess.DEVNULL)
        return name, path

    for size in BALLS:
        yield extracted(f"ball {size}", f"phantom:sphere,size={size}", "0.501")
    yield extracted("skull", "example:ct-head", "300")


def timed(isolux, path, size, frames):
    """Triangles, and a frame by rays and by raster in ms, and the median ratio of their pairs."""
    told = json.loads(subprocess.run([isolux, "info", path, "--json"], check=True,
                                     capture_output=True, text=True).stdout)
    report = json.loads(subprocess.run(
        [isolux, "bench", path, "--size", f"{size}x{size}", "--frames", str(frames), "--json"],
        check=True, capture_output=True, text=True).stdout)
    row = next(r for r in report["rows"] if r["work"] == "mesh frame, raster")
    rays = row["against"][0]
    return told["triangles"], rays["median"], row["median"], rays["ratio"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("meshes", nargs="*", type=Path)
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/bench/isolux"))
    parser.add_argument("--frames", type=int, default=11)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    lines = ["| mesh | triangles | picture | rays, ms | raster, ms | raster is faster by |",
             "| --- | ---: | ---: | ---: | ---: | ---: |"]
    with tempfile.TemporaryDirectory() as folder:
        meshes = list(made_meshes(options.isolux, Path(folder)))
        meshes += [(path.stem, path) for path in options.meshes]
        for name, path in meshes:
            for size in SIZES:
                triangles, rays, raster, ratio = timed(options.isolux, path, size, options.frames)
                lines.append(f"| {name} | {triangles:,} | {size}² | {rays:.1f} | {raster:.1f} "
                             f"| {ratio:.1f} |")
    table = "\n".join(lines) + "\n"
    print(table, end="")
    if options.write:
        write_table(DOCS / "meshes.md", BEGIN, END, table)


if __name__ == "__main__":
    main()
