#!/usr/bin/env python3
"""Makes every picture of the manual's pages again, by the commands that the pages themselves show.

The pages are the only list: each `isolux` or `python3 docs/...` line in a ```sh block is run, in
order, in an empty folder that holds the small raw volumes written here. `-o NAME.png` becomes
docs/pictures/NAME.png. Where a ```text block follows, its lines must occur, in order, in what the
last command before it prints.

    python3 docs/make_pictures.py [--isolux PATH] [--out DIR]   makes the pictures
    python3 docs/make_pictures.py [--isolux PATH] --check       compares them byte for byte with
                                                                docs/pictures; exit 1 if any differ
    python3 docs/make_pictures.py --volumes DIR                 writes the volumes alone

What needs the CT scan (an isolux command without an input) is skipped, and named, where the scan
is not on this machine; a script says itself, by the exit status 77, that it lacks something.
Standard library only.
"""

import argparse
import array
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from math import cos, hypot, radians, sin, sqrt
from pathlib import Path

sys.dont_write_bytecode = True
from lecture_loop import read_png  # noqa: E402

DOCS = Path(__file__).resolve().parent
PAGES = [DOCS / name for name in ("lighting.md", "rays.md", "indirect.md")]
PICTURES = DOCS / "pictures"


# ---- The volumes: fields that are positive inside a body, so that the iso value 0 is its skin.

def save(path, dims, field):
    """f32 voxels, i fastest; `field(i, j, k)` is rounded, so that no machine's libm shows."""
    ni, nj, nk = dims
    voxels = array.array("f", (round(field(i, j, k), 4)
                               for k in range(nk) for j in range(nj) for i in range(ni)))
    if sys.byteorder == "big":
        voxels.byteswap()
    path.write_bytes(voxels.tobytes())


def inside_box(p, half_sizes):
    return min(h - abs(x) for x, h in zip(p, half_sizes))


def write_floor(folder):
    """Two layers of 2 x 2 voxels, 1 below 0: at 0.5 a level plane."""
    (folder / "floor.raw").write_bytes(bytes([1, 1, 1, 1, 0, 0, 0, 0]))


def write_balls(folder):
    """Three balls of radius 14 in a row along x."""
    save(folder / "balls.raw", (97, 33, 33),
         lambda i, j, k: 14 - sqrt((i % 32 - 16 if i < 96 else 16) ** 2
                                   + (j - 16) ** 2 + (k - 16) ** 2))


def write_bowl(folder):
    """The lower half of a ball of radius 22: the box ends at its equator, so it is open there."""
    save(folder / "bowl.raw", (49, 49, 25),
         lambda i, j, k: 22 - sqrt((i - 24) ** 2 + (j - 24) ** 2 + (k - 24) ** 2))


def write_beams(folder):
    """Two plates, level and tilted by 45 degrees, and a beam of five rays onto each."""
    tilt, half_sizes = radians(45), (27, 18, 2)
    level_at, tilted_at, across = (36, 22, 14), (112, 22, 30), 8

    def plates(i, j, k):
        level = inside_box((i - level_at[0], j - level_at[1], k - level_at[2]), half_sizes)
        x, z = i - tilted_at[0], k - tilted_at[2]
        tilted = inside_box((x * cos(tilt) + z * sin(tilt), j - tilted_at[1],
                             z * cos(tilt) - x * sin(tilt)), half_sizes)
        return max(level, tilted)

    def beams(i, j, k):
        at = level_at if i < 74 else tilted_at
        ray = max(-2, min(2, round((i - at[0]) / across)))
        beside = hypot(i - at[0] - ray * across, j - at[1])
        plate = at[2] + (0 if i < 74 else ray * across)  # the ray ends within the plate
        return min(1.3 - beside, k - plate, 76 - k)

    save(folder / "plates.raw", (149, 45, 79), plates)
    save(folder / "beams.raw", (149, 45, 79), beams)


def write_lobes(folder):
    """Phong's highlight as a body: in direction w its skin lies at 60 max(0, w.r)^n."""
    dims, at, s = (115, 65, 71), (47, 32, 5), sqrt(0.5)
    r = (s, 0, s)

    def rod(p, direction, length):
        along = sum(a * b for a, b in zip(p, direction))
        beside = sqrt(max(0, sum(a * a for a in p) - along * along))
        return min(1.3 - beside, along, length - along)

    def from_at(i, j, k):
        return i - at[0], j - at[1], k - at[2]

    def lobe(n):
        def field(i, j, k):
            p = from_at(i, j, k)
            length = sqrt(sum(a * a for a in p))
            if length == 0:
                return 0
            return 60 * max(0, (p[0] * r[0] + p[2] * r[2]) / length) ** n - length
        return field

    for n in (1, 5, 20, 100):
        save(folder / f"lobe_{n}.raw", dims, lobe(n))
    save(folder / "lobe_table.raw", dims,
         lambda i, j, k: inside_box((i - at[0], j - at[1], k - at[2] + 2), (44, 29, 2)))
    save(folder / "lobe_rays.raw", dims,
         lambda i, j, k: max(rod(from_at(i, j, k), (-s, 0, s), 66),
                             rod(from_at(i, j, k), r, 80)))


def write_mirror(folder):
    """A ball of radius 26 mm that hangs before the brow of the CT head."""
    header = ("NRRD0004\ntype: float\ndimension: 3\nsizes: 61 61 61\n"
              "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
              "space origin: (20,-290,70)\nencoding: raw\nendian: little\n"
              "data file: mirror.raw\n")
    (folder / "mirror.nhdr").write_text(header)
    save(folder / "mirror.raw", (61, 61, 61),
         lambda i, j, k: 26 - sqrt((i - 30) ** 2 + (j - 30) ** 2 + (k - 30) ** 2))


def write_volumes(folder):
    for write in (write_floor, write_balls, write_bowl, write_beams, write_lobes, write_mirror):
        write(folder)


# ---- The page's commands

class Command:
    """The words of one line, and the lines that it must print."""

    def __init__(self, line):
        self.line, self.words, self.printed = line, shlex.split(line), []
        after_o = self.words.index("-o") + 1 if "-o" in self.words else None
        self.picture = self.words[after_o] if after_o else None

    def needs_scan(self):
        inputs, words = [], iter(self.words[2:])
        for word in words:
            if word.startswith("-"):
                next(words, None)  # every option that the page uses takes a value
            else:
                inputs.append(word)
        return self.words[0] == "isolux" and (not inputs or "example:ct-head" in inputs)


def page_commands(text):
    commands = []
    for kind, body in re.findall(r"^```(sh|text)\n(.*?)^```$", text, re.M | re.S):
        if kind == "text":
            commands[-1].printed = [line.strip() for line in body.splitlines()
                                    if line.strip() not in ("", "...")]
            continue
        for line in re.sub(r"\\\n\s*", "", body).splitlines():
            if line.startswith(("isolux ", "python3 docs/")):
                commands.append(Command(line))
    return commands


def run(command, isolux, folder):
    """What it prints, or None if it says (77) that it has been skipped."""
    if command.words[0] == "isolux":
        words = [isolux, *command.words[1:]]
    else:
        script, *more = command.words[1:]
        words = [sys.executable, str(DOCS.parent / script), "--isolux", isolux, *more]
    done = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True)
    if done.returncode == 77:
        return None
    if done.returncode != 0:
        sys.exit(f"failed: {command.line}\n{done.stdout}{done.stderr}")
    return done.stdout


def first_line_missing(wanted, printed):
    lines = iter(line.strip() for line in printed.splitlines())
    return next((line for line in wanted if line not in lines), None)


def difference(made, kept):
    """What sets two picture files apart, or None."""
    if not kept.exists():
        return "is not in docs/pictures"
    a, b = made.read_bytes(), kept.read_bytes()
    if a == b:
        return None
    (wide, high, rows), (kept_wide, kept_high, kept_rows) = read_png(a), read_png(b)
    if (wide, high) != (kept_wide, kept_high):
        return f"is {wide} x {high}, was {kept_wide} x {kept_high}"
    pixels = sum(row[3 * x:3 * x + 3] != kept_row[3 * x:3 * x + 3]
                 for row, kept_row in zip(rows, kept_rows) for x in range(wide))
    return (f"{pixels} of {wide * high} pixels differ" if pixels else
            "same pixels, but another record of how it was made, or other compression")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--isolux", default=str(DOCS.parent / "build/release/isolux"),
                        help="the program (default: %(default)s)")
    parser.add_argument("--out", default=str(PICTURES), help="where to (default: %(default)s)")
    parser.add_argument("--check", action="store_true",
                        help="write nothing; compare with docs/pictures")
    parser.add_argument("--volumes", metavar="DIR", help="write the raw volumes there, and stop")
    arguments = parser.parse_args()
    if arguments.volumes:
        Path(arguments.volumes).mkdir(parents=True, exist_ok=True)
        write_volumes(Path(arguments.volumes))
        return 0

    isolux = str(Path(arguments.isolux).resolve())
    about_head = subprocess.run([isolux, "info"], capture_output=True, text=True, check=True)
    has_scan = "phantom" not in about_head.stdout + about_head.stderr
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    commands = page_commands(text)
    faults, skipped, made = [], [], []
    with tempfile.TemporaryDirectory(prefix="isolux-pictures-") as name:
        folder = Path(name)
        write_volumes(folder)
        for command in commands:
            if command.needs_scan() and not has_scan:
                printed = None
            else:
                printed = run(command, isolux, folder)
            if printed is None:
                skipped.append(command.picture or command.line)
                continue
            missing = first_line_missing(command.printed, printed)
            if missing is not None:
                faults.append(f"{command.line}\n    no longer prints: {missing}")
            if command.picture:
                made.append(command.picture)
        if arguments.check:
            for picture in made:
                if found := difference(folder / picture, PICTURES / picture):
                    faults.append(f"{picture}: {found}")
        else:
            Path(arguments.out).mkdir(parents=True, exist_ok=True)
            for picture in made:
                shutil.copy(folder / picture, Path(arguments.out) / picture)
    shown = set(re.findall(r"\(pictures/([^)]+)\)", text))
    listed = {command.picture for command in commands if command.picture}
    kept = {path.name for path in PICTURES.glob("*.png")}
    faults += [f"{picture}: shown on the page, but no command makes it"
               for picture in sorted(shown - listed)]
    faults += [f"{picture}: in docs/pictures, but no command of the page makes it"
               for picture in sorted(kept - listed)]

    for picture in skipped:
        print(f"skipped, for its scan or mesh is not on this machine: {picture}")
    for fault in faults:
        print(f"differs: {fault}")
    print(f"{len(made)} pictures made, {len(skipped)} commands skipped, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
