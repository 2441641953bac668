"""What `isolux bench` measures and prints; not how fast anything is."""

import json
import struct
import subprocess
import sys
import unittest

from isolux import PROGRAM, ROOT, USAGE, WORK, TestCase
from pictures import BLOB_DIMS, blob, grid

MESH_WORKS = ["mesh tree", "mesh frame, raycast", "mesh frame, raster", "incoherent rays on mesh",
              "shadow rays on mesh"]
SCENE_WORKS = ["min-max bricks", "visibility", "display", "frame", "incoherent rays",
               "shadow rays", "lamp moved", "lamp moved, shadows", "new iso value", "first picture",
               "extraction", *MESH_WORKS]
PEER_WORKS = ["orbit", "close view", "inside view", "incoherent rays", "shadow rays", "lamp moved",
              "new iso value", "first picture", "min-max bricks", "extraction", *MESH_WORKS]

# A peer that takes 5 ms for everything and draws black pictures; MODE is its first argument.
FAKE = """#!/usr/bin/env python3
import sys
if sys.argv[1] in ABSENT:
    sys.exit("no screen")
print("ready Fake " + sys.argv[1], flush=True)
for line in sys.stdin:
    words = line.split()
    if words[0] == "picture":
        with open(words[1], "wb") as file:
            file.write(b"P6\\n16 16\\n255\\n" + bytes(3 * 16 * 16))
    if words[0] == "write-mesh":
        open(words[1], "wb").write(bytes(16))
    if words[0] == "read-mesh" and len(open(words[1], "rb").read()) < 16:
        print("error no mesh", flush=True)
    print("error tired" if words[0] == FAILS_AT else "ok 5 64 1", flush=True)
"""
SMALL = ["phantom:head,size=16", "--size", "16x16", "--frames", "2"]


class Bench(TestCase):
    def report(self, *words):
        """The JSON object and what was told beside it."""
        done = self.run_isolux("bench", *words, "--json")
        return json.loads(done.stdout), done.stderr

    def write_peers(self, fails_at=None, absent=()):
        for name in ("embree_peer", "vtk_peer"):
            path = self.folder / name
            path.write_text(FAKE.replace("FAILS_AT", repr(fails_at)).replace("ABSENT", repr(absent)))
            path.chmod(0o755)

    def check_rows(self, rows, works):
        self.assertEqual([row["work"] for row in rows], works)
        for row in rows:
            self.assertGreater(row["median"], 0, row)
            self.assertIn(row["unit"], ("ms", "M rays/s"))
            self.assertEqual("rays" in row["work"], row["unit"] == "M rays/s")

    def test_every_work_of_a_scene_has_its_row(self):
        report, _ = self.report(*SMALL)
        self.check_rows(report["rows"], SCENE_WORKS)
        self.assertEqual((report["width"], report["height"]), (16, 16))
        self.assertGreaterEqual(report["load_average_before"], 0)
        against = {row["work"]: [other["name"] for other in row["against"]]
                   for row in report["rows"] if row["against"]}
        self.assertEqual(against, {"min-max bricks": ["every voxel read once"],
                                   "lamp moved": ["the same bytes streamed"],
                                   "mesh frame, raster": ["raycast"]})
        self.assertTrue(all(row["turns"] == 2 for row in report["rows"]))

    def test_the_table_for_a_person_has_the_same_rows(self):
        text = self.run_isolux("bench", *SMALL).stdout
        for work in SCENE_WORKS:
            self.assertRegex(text, rf"(?m)^{work} +\d+\.\d\d +\d+\.\d\d  (ms|M rays/s)")
        self.assertIn("16x16", text.splitlines()[-1])
        self.assertIn("load average", text.splitlines()[-1])

    def test_without_peers_they_are_named_and_isolux_is_measured_against_itself(self):
        report, told = self.report(*SMALL, "--peers", "--peers-in", self.folder)
        self.assertRegex(told, "left out: .*/vtk_peer: No such file")
        self.assertRegex(told, "left out: Embree: it draws the mesh that VTK extracts")
        subjects = [f"{name} {size}" for size in ("16x16x16", "32x32x32")
                    for name in ("bone", "skin")]
        self.assertEqual([row["subject"] for row in report["rows"]],
                         [s for s in subjects for _ in PEER_WORKS])
        self.check_rows(report["rows"], PEER_WORKS * 4)
        again = {other["name"]: other for other in report["rows"][0]["against"]}
        for name in ("isolux again", "isolux, 1 thread"):
            self.assertIn("differs by 0.0 of 255", again[name]["note"])

    def test_a_peer_takes_part_in_each_work_that_it_can_do(self):
        self.write_peers()
        report, _ = self.report(*SMALL, "--peers", "--peers-in", self.folder)
        threads = str(report["threads"])
        vtk = ["Fake mesh", "Fake volume", "Fake step"]
        embree = "Fake " + threads
        for row in report["rows"]:
            others = [o["name"] for o in row["against"] if o["name"].startswith("Fake")]
            wanted = {"first picture": [], "min-max bricks": [], "incoherent rays": [embree],
                      "shadow rays": [embree], "extraction": vtk[:1],
                      **{work: [embree] for work in MESH_WORKS},
                      "mesh frame, raster": vtk[:1]}.get(row["work"], [embree, *vtk])
            if row["work"] == "inside view" and row["subject"].startswith("skin"):
                wanted = [embree, *vtk[:2]]  # the eye is in the body that "step" fills
            self.assertEqual(others, wanted, row["work"])
        orbit = report["rows"][0]["against"][0]
        self.assertEqual((orbit["median"], orbit["p99"], orbit["turns"]), (5, 5, 2))
        self.assertIn("25.0 % hit", orbit["note"])  # 64 of 16x16
        new_iso = {o["name"]: o["median"] for row in report["rows"][:len(PEER_WORKS)]
                   if row["work"] == "new iso value" for o in row["against"]}
        # Extraction and drawing are 5 ms each; Embree's tree over the mesh is 5 ms more.
        self.assertEqual(new_iso, {embree: 15, **{name: 10 for name in vtk}})

    def test_another_build_takes_part_like_a_peer_and_draws_the_same(self):
        report, _ = self.report(*SMALL, "--peers", "--peers-in", self.folder,
                                "--against", PROGRAM)
        for row in report["rows"]:
            others = {o["name"]: o for o in row["against"]}
            self.assertEqual("other isolux" in others,
                             row["work"] not in ("first picture", "min-max bricks", "extraction"),
                             row["work"])
            if "view" in row["work"] or "frame" in row["work"]:
                self.assertIn("differs by 0.0 of 255", others["other isolux"]["note"])

    def test_a_mesh_is_timed_with_and_without_peers(self):
        self.run_isolux("mesh", "phantom:head,size=16", "head.stl", "--iso", "300")
        report, _ = self.report("head.stl", *SMALL[1:])
        self.check_rows(report["rows"], MESH_WORKS)
        self.write_peers()
        (self.folder / "pictures").mkdir()
        report, _ = self.report("head.stl", *SMALL[1:], "--peers", "--peers-in", self.folder,
                                "--against", PROGRAM, "--pictures", "pictures")
        self.check_rows(report["rows"], MESH_WORKS)
        for row in report["rows"]:
            others = {o["name"]: o for o in row["against"]}
            rival = "Fake mesh" if "raster" in row["work"] else f"Fake {report['threads']}"
            self.assertEqual(set(others), {rival, "other isolux"})
            if "frame" in row["work"]:
                self.assertIn("differs by 0.0 of 255", others["other isolux"]["note"])
        self.assertIn("head.stl_mesh_frame,_raster_isolux.png",
                      {path.name for path in (self.folder / "pictures").iterdir()})

    def test_slow_peers_and_other_works_take_21_turns_at_most_of_a_long_orbit(self):
        self.write_peers(absent=("volume", "step"))
        report, told = self.report("phantom:head,size=8", "--size", "8x8", "--frames", "43",
                                   "--peers", "--peers-in", self.folder)
        self.assertIn("left out: VTK volume, ct-head: it has ended (no screen)", told)
        turns = {o["name"]: o["turns"] for o in report["rows"][0]["against"]}
        self.assertEqual(turns["Fake mesh"], 15)  # every third of 43, the first included
        self.assertEqual(turns["Fake " + str(report["threads"])], 43)
        self.assertEqual(report["rows"][1]["against"][0]["turns"], 21)

    def test_pictures_of_every_side_are_kept_where_asked(self):
        self.write_peers()
        (self.folder / "pictures").mkdir()
        self.run_isolux("bench", *SMALL, "--peers", "--peers-in", self.folder,
                        "--pictures", "pictures")
        names = {path.name for path in (self.folder / "pictures").iterdir()}
        self.assertIn("bone_16x16x16_orbit_isolux.png", names)
        self.assertIn("skin_32x32x32_inside_view_Fake_mesh.png", names)

    def test_a_peer_that_fails_on_the_way_is_one_clear_error(self):
        self.write_peers(fails_at="frame")
        done = self.run_isolux("bench", *SMALL, "--peers", "--peers-in", self.folder, status=WORK)
        self.assertFalse(done.stdout)
        self.assertRegex(done.stderr.splitlines()[-1], "isolux: error: Fake .*: .*error tired.*; ")

    def test_a_scene_of_ones_own_or_other_voxels_do_not_go_with_peers(self):
        self.refused("bench", "--peers", "--surface", "iso=5", status=USAGE, about="--surface")
        self.refused("bench", "phantom:head", "phantom:head", "--peers", status=USAGE)
        self.refused("bench", "phantom:sphere", "--peers", status=WORK, about="f32")


class AsPeer(TestCase):
    def answers(self, *requests):
        done = self.run_isolux("bench", "--as-peer", "Own", input="\n".join(requests) + "\n")
        ready, *answers = done.stdout.splitlines()
        self.assertEqual(ready, "ready Own")
        return answers

    def test_a_volume_is_drawn_on_request_and_the_same_request_gives_the_same_bytes(self):
        values = grid(BLOB_DIMS, blob)
        (self.folder / "raw").write_bytes(struct.pack(f"<{len(values)}h", *values))
        dims = " ".join(map(str, BLOB_DIMS))
        frame = "frame 8 -60 8 8 7 6 30"
        answers = self.answers("size 32 32", f"volume raw {dims} 1 1 1", "iso 0", frame, frame,
                               "lamp -50 -50 50", frame, "headlight", frame, "picture out.ppm")
        self.assertTrue(all(a.startswith("ok") for a in answers), answers)
        frames = [answers[n].split()[2:] for n in (3, 4, 6, 8)]
        self.assertGreater(int(frames[0][0]), 0)
        self.assertEqual(frames[0], frames[1])
        self.assertNotEqual(frames[0][1], frames[2][1])
        self.assertEqual(frames[0], frames[3])
        self.assertTrue((self.folder / "out.ppm").read_bytes().startswith(b"P6\n32 32\n255\n"))

    def test_what_it_cannot_do_is_an_error_and_it_goes_on(self):
        answers = self.answers("dance", "frame 1 2", "frame 1 2 3 4 5 6 30", "iso 3", "size 8 8",
                               "volume none 2 2 2 1 1 1")
        self.assertEqual([a.split()[0] for a in answers],
                         ["error"] * 4 + ["ok", "error"])


class Cycles(TestCase):
    def test_without_blender_it_says_what_is_missing_and_how_to_get_it(self):
        done = subprocess.run([sys.executable, ROOT / "bench/cycles.py", "--blender",
                               self.folder / "none"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^bench/cycles.py: .*/none: is not installed; apt-get .*\n$")


if __name__ == "__main__":
    unittest.main()
