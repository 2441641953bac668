#!/usr/bin/env python3
"""Times indirect light by paths against Blender's Cycles, in turn: see bench/README.md.

    python3 bench/cycles.py [--isolux PATH] [--blender PATH] [--input FILE] [--iso V] [--spp N]
                            [--bounces N] [--turns N] [--size N] [--threads N] [--pictures DIR]
                            [--json]

isolux draws the isosurface and, as another process, the mesh that it extracts; Cycles that mesh.
Whole frames with shadows, once with the bounces and once without. Standard library only.
"""

import argparse
import json
import math
import os
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

BENCH = Path(__file__).resolve().parent
FOV = 30
NEARNESS = {"whole head": 1, "close": 2.2}


class Peer:
    """A process that answers line by line. Blender tells its version before anything else."""

    def __init__(self, words, log):
        self.process = subprocess.Popen(list(map(str, words)), stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=log, text=True, bufsize=1)
        self.name = self.answer("ready", skip="Blender ")

    def answer(self, begin, skip="\n"):
        line = self.process.stdout.readline()
        while line.startswith(skip):
            line = self.process.stdout.readline()
        line = line.strip()
        if not line.startswith(begin):
            sys.exit(f"bench/cycles.py: {self.process.args[0]}: it says '{line}'; see the log "
                     "with --pictures DIR")
        return line[len(begin):].strip()

    def ask(self, *words):
        print(*words, file=self.process.stdin, flush=True)
        return self.answer("ok").split()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def run(*words):
    subprocess.run(list(map(str, words)), check=True, stderr=subprocess.DEVNULL)


def write_raw(isolux, source, folder):
    """The voxels as 16-bit integers in head.raw; (dims, spacing)."""
    run(isolux, "convert", source, folder / "head.nii")
    nifti = (folder / "head.nii").read_bytes()
    (kind,) = struct.unpack_from("<h", nifti, 70)
    if kind != 4:
        sys.exit(f"bench/cycles.py: {source}: is not of 16-bit integers; take another CT scan")
    (begin,) = struct.unpack_from("<f", nifti, 108)
    (folder / "head.raw").write_bytes(nifti[int(begin):])
    return struct.unpack_from("<3h", nifti, 42), struct.unpack_from("<3f", nifti, 80)


def write_peer_mesh(ply, path):
    """From the PLY that isolux writes to the file of src/isolux/bench/mesh_file.h."""
    head, body = ply.read_bytes().split(b"end_header\n", 1)
    vertices, faces = (int(line.split()[2]) for line in head.decode().splitlines()
                       if line.startswith("element"))
    end = 24 * vertices  # x, y, z, nx, ny, nz as floats
    with open(path, "wb") as file:
        file.write(struct.pack("<2Q", vertices, faces))
        for part in (0, 12):
            file.write(b"".join(body[at + part:at + part + 12] for at in range(0, end, 24)))
        file.write(b"".join(body[at + 1:at + 13] for at in range(end, end + 13 * faces, 13)))


def view(box_mm, nearness):
    """Words of `frame` and of `lamp`: that of `isolux bench` at 0 degrees, the lamp at the left
    above the eye."""
    middle = [side / 2 for side in box_mm]
    distance = math.hypot(*middle) / math.sin(math.radians(FOV / 2)) / nearness
    back = [0, -1 / math.hypot(1, 0.2), 0.2 / math.hypot(1, 0.2)]
    up = [0, -back[2] * -1, -back[1]]
    eye = [m + distance * b for m, b in zip(middle, back)]
    lamp = [e + distance * (0.6 * u) for e, u in zip(eye, up)]
    lamp[0] -= 0.45 * distance
    return [*eye, *middle, FOV], lamp


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(BENCH.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--blender", default="blender", help="the peer (default: %(default)s)")
    parser.add_argument("--input", default="example:ct-head", help="a CT scan (%(default)s)")
    parser.add_argument("--iso", default="300", help="its iso value (%(default)s)")
    parser.add_argument("--spp", type=int, default=16, help="samples a pixel (%(default)s)")
    parser.add_argument("--bounces", type=int, default=4, help="how deep (%(default)s)")
    parser.add_argument("--turns", type=int, default=3, help="that are counted (%(default)s)")
    parser.add_argument("--size", type=int, default=1024, help="pixels a side (%(default)s)")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="(all cores)")
    parser.add_argument("--pictures", metavar="DIR", help="keep the pictures and the log there")
    parser.add_argument("--json", action="store_true", help="print a JSON object")
    asked = parser.parse_args()
    if not shutil.which(asked.blender):
        sys.exit(f"bench/cycles.py: {asked.blender}: is not installed; "
                 "apt-get install --no-install-recommends blender")

    with tempfile.TemporaryDirectory(prefix="isolux-cycles-") as name:
        folder = Path(name)
        kept = Path(asked.pictures or name).resolve()
        kept.mkdir(parents=True, exist_ok=True)
        dims, spacing = write_raw(asked.isolux, asked.input, folder)
        raw = ["--dims", "x".join(map(str, dims)), "--type", "i16",
               "--spacing", ":".join(map(str, spacing))]
        run(asked.isolux, "mesh", folder / "head.raw", folder / "bone.ply", "--iso", asked.iso, *raw)
        write_peer_mesh(folder / "bone.ply", folder / "bone.mesh")
        with open(kept / "log.txt", "w", encoding="utf-8") as log:
            own = [asked.isolux, "bench", "--threads", asked.threads, "--as-peer"]
            peers = {
                "isolux, isosurface": Peer([*own, "isosurface"], log),
                "isolux, mesh": Peer([*own, "mesh"], log),
                "Cycles, mesh": Peer([asked.blender, "-b", "-noaudio", "--factory-startup", "-P",
                                      BENCH / "peers/cycles_peer.py", "--", asked.threads], log)}
            report = contest(peers, asked, folder, kept, dims, spacing)
            for peer in peers.values():
                peer.end()
    print(json.dumps(report, indent=1) if asked.json else text_of(report))


def contest(peers, asked, folder, kept, dims, spacing):
    on_iso, on_mesh, cycles = peers.values()
    load = os.getloadavg()[0]
    for peer in peers.values():
        peer.ask("size", asked.size, asked.size)
    on_iso.ask("volume", folder / "head.raw", *dims, *spacing)
    on_iso.ask("iso", asked.iso)
    for peer in (on_mesh, cycles):
        peer.ask("read-mesh", folder / "bone.mesh")
    rows = []
    for seen, nearness in NEARNESS.items():
        frame, lamp = view([(n - 1) * mm for n, mm in zip(dims, spacing)], nearness)
        for peer in peers.values():
            peer.ask("lamp", *lamp)
        seconds = {who: {0: [], asked.bounces: []} for who in peers}
        for turn in range(asked.turns + 1):  # the first is not counted
            for bounces in (0, asked.bounces):
                for who, peer in peers.items():
                    peer.ask("paths", asked.spp, bounces)
                    answer = peer.ask("frame", *frame)
                    if turn > 0:
                        seconds[who][bounces].append(float(answer[0]) / 1000)
                    if peer is on_iso:
                        hits = int(answer[1])
        for who, peer in peers.items():
            if asked.pictures:
                ending = "png" if peer is cycles else "ppm"
                peer.ask("picture", kept / f"{seen}, {who}.{ending}".replace(" ", "_"))
            rows.append(row(seen, who, seconds[who], seconds["Cycles, mesh"], asked, hits))
    return {"peer": cycles.name, "input": asked.input, "size": asked.size, "spp": asked.spp,
            "bounces": asked.bounces, "turns": asked.turns, "threads": asked.threads,
            "load_average_before": load, "load_average_after": os.getloadavg()[0], "rows": rows}


def row(seen, who, seconds, of_cycles, asked, hits):
    """Medians over turns; a ratio is one of a turn's two frames."""
    def indirect(times):
        return [b - a for a, b in zip(times[0], times[asked.bounces])]

    def ratio(theirs, ours):
        return statistics.median(a / b for a, b in zip(theirs, ours))

    whole = statistics.median(seconds[asked.bounces])
    return {"view": seen, "who": who, "frame_s": whole,
            "without_bounces_s": statistics.median(seconds[0]),
            "samples_per_s": asked.size ** 2 * asked.spp / whole,
            "share_hit": hits / asked.size ** 2,
            "ratio": ratio(of_cycles[asked.bounces], seconds[asked.bounces]),
            "ratio_of_bounces": ratio(indirect(of_cycles), indirect(seconds))}


def text_of(report):
    lines = ["| view | who | a frame | of it without bounces | samples a second | times as fast as "
             "Cycles | bounces alone |", "| --- | --- | ---: | ---: | ---: | ---: | ---: |"]
    for r in report["rows"]:
        lines.append(f"| {r['view']} ({100 * r['share_hit']:.0f} % hit) | {r['who']} | "
                     f"{r['frame_s']:.2f} s | {r['without_bounces_s']:.2f} s | "
                     f"{r['samples_per_s'] / 1e6:.1f} M | {r['ratio']:.2f} | "
                     f"{r['ratio_of_bounces']:.2f} |")
    lines.append("{peer}, {input}, {size}x{size}, {spp} samples a pixel, {bounces} bounces, "
                 "{threads} threads, medians of {turns} turns; load average "
                 "{load_average_before:.2f} before, {load_average_after:.2f} after".format(**report))
    return "\n".join(lines)


if __name__ == "__main__":
    main()
