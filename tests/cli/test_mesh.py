"""`isolux mesh`: what it writes, read back from the bytes alone."""

import json
import re
import struct
import unittest
from collections import Counter

from isolux import USAGE, WORK, TestCase


def stl_facets(path):
    """[(normal, corner, corner, corner), ...] of a binary STL, and its header."""
    data = path.read_bytes()
    count, = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    facets = []
    for n in range(count):
        f = struct.unpack_from("<12f", data, 84 + 50 * n)
        facets.append((f[0:3], f[3:6], f[6:9], f[9:12]))
    return facets, data[:80]


class Extraction(TestCase):
    def test_a_sphere_is_closed_outward_and_round(self):
        done = self.run_isolux("mesh", "phantom:sphere,size=33", "ball.stl", "--iso", "0.501")
        self.assertIn("watertight", done.stderr)
        self.assertNotIn("not watertight", done.stderr)
        facets, header = stl_facets(self.folder / "ball.stl")
        self.assertIn(b"SPACE=LPS", header)
        sides = Counter()
        for normal, a, b, c in facets:
            self.assertGreater(sum(n * p for n, p in zip(normal, a)), 0)
            sides.update([(a, b), (b, c), (c, a)])
            for corner in (a, b, c):
                # 1 - r / 32 = 0.501 at r = 15.968 mm; chords of 2 mm cells bulge by up to
                # 3 * 2^2 / (8 * 16) = 0.09 mm.
                self.assertAlmostEqual(sum(x * x for x in corner) ** 0.5, 15.968, delta=0.1)
        # Every side runs once each way.
        self.assertEqual({n for n in sides.values()}, {1})
        self.assertTrue(all((b, a) in sides for a, b in sides))

    def test_ras_is_lps_with_x_and_y_negated(self):
        for space in ("lps", "ras"):
            self.run_isolux("mesh", "phantom:head,size=24", f"{space}.stl", "--iso", "300",
                            "--space", space)
        lps, _ = stl_facets(self.folder / "lps.stl")
        ras, header = stl_facets(self.folder / "ras.stl")
        self.assertIn(b"SPACE=RAS", header)
        self.assertEqual([[(-x, -y, z) for x, y, z in facet] for facet in lps],
                         [list(facet) for facet in ras])

    def test_the_distance_to_the_exact_surface_is_told(self):
        done = self.run_isolux("mesh", "phantom:sphere", "ball.ply", "--iso", "0.5")
        mean, most = map(float, re.search(r"surface: (\S+) mm on average, (\S+) mm at the most",
                                          done.stderr).groups())
        # A chord of sqrt(2) mm in a circle of 16 mm leaves it by 2 / (8 * 16) mm.
        self.assertTrue(0 < mean < most < 2 / (8 * 16))

    def test_decimation_keeps_a_share_and_the_same_bytes_come_from_any_number_of_threads(self):
        for threads in (1, 3):
            self.run_isolux("mesh", "phantom:head,size=48", f"{threads}.glb", "--iso", "-300",
                            "--decimate", "0.2", "--threads", threads)
        one, three = ((self.folder / f"{n}.glb").read_bytes() for n in (1, 3))
        self.assertEqual(one, three)

    def test_without_an_iso_value_the_first_suggested_one_is_taken(self):
        done = self.run_isolux("mesh", "phantom:head,size=32", "head.obj")
        self.assertIn("iso value 300 (bone)", done.stderr)

    def test_what_cannot_be_done_is_refused(self):
        sphere = "phantom:sphere,size=9"
        self.refused("mesh", sphere, "a.stl", "--iso", "9", status=WORK, about="no surface")
        self.refused("mesh", sphere, "a.vtk", "--iso", "0", status=USAGE, about="format")
        self.refused("mesh", sphere, status=USAGE, about="one OUT")
        self.refused("mesh", sphere, "a.glb", "--iso", "0", "--space", "ras", status=USAGE)
        self.refused("mesh", sphere, "a.stl", "--decimate", "0", status=USAGE)
        self.refused("mesh", sphere, "no/a.stl", "--iso", "0", status=WORK)
        self.assertEqual(list(self.folder.iterdir()), [])


class Meshes(TestCase):
    def cube(self, name="cube.obj", x0=0, edge=1):
        """A cube from (x0, 0, 0) on, outward, as an OBJ of quads."""
        corners = [(x0 + x * edge, y * edge, z * edge)
                   for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
        lines = ["v %d %d %d" % c for c in corners] + ["f %d %d %d %d" % f for f in faces]
        (self.folder / name).write_text("\n".join(lines) + "\n")

    def test_info_tells_what_a_mesh_is(self):
        self.cube()
        told = json.loads(self.run_isolux("info", "cube.obj", "--json").stdout)
        self.assertEqual((told["kind"], told["vertices"], told["triangles"]), ("mesh", 8, 12))
        self.assertEqual(told["box"], [[0, 0, 0], [1, 1, 1]])
        self.assertTrue(told["watertight"])
        self.assertEqual(told["materials"][0]["kd"], [0.8, 0.8, 0.8])
        self.assertIn("watertight", self.run_isolux("info", "cube.obj").stdout)

    def test_a_mesh_is_converted(self):
        self.cube()
        done = self.run_isolux("mesh", "cube.obj", "cube.stl", "--space", "ras")
        self.assertIn("watertight", done.stderr)
        self.run_isolux("mesh", "cube.stl", "back.glb")
        told = json.loads(self.run_isolux("info", "back.glb", "--json").stdout)
        self.assertEqual((told["triangles"], told["watertight"]), (12, True))
        # Out to RAS, back by its tag, and through glTF's metres.
        self.assert_near(told["box"][0] + told["box"][1], [0, 0, 0, 1, 1, 1])

    def test_commands_for_volumes_refuse_a_mesh(self):
        self.cube()
        self.refused("convert", "cube.obj", "a.nrrd", status=USAGE, about="is a mesh")
        self.refused("mesh", "cube.obj", "a.stl", "--iso", "1", status=USAGE, about="already")
        self.refused("info", "cube.obj", "--spacing", "1:1:1", status=USAGE, about="no input")

    def test_a_mesh_and_a_volume_hide_each_other(self):
        self.cube()
        # A sphere of 16 mm about the origin hides a cube of 1 mm inside it, not one beside it.
        small = {"size": "48x44"}

        def seen(*inputs, **options):
            picture = self.exr(*inputs, **small, **options)
            return {picture.at("surface.id", x, y) for x, y in picture.pixels()} - {-1.0}

        self.assertEqual(seen("phantom:sphere", "cube.obj", surface="iso=0.5"), {0.0})
        self.assertEqual(seen("cube.obj"), {0.0})
        self.cube("far.obj", x0=20, edge=10)
        self.assertEqual(seen("phantom:sphere", "far.obj", surface="iso=0.5"), {0.0, 1.0})

    def test_raster_and_rays_give_the_same_picture_of_a_mesh(self):
        self.run_isolux("mesh", "phantom:head,size=48", "head.ply", "--iso", "300")
        camera = {"size": "120x90", "light": "point,at=-300:-400:300"}
        for view in ("front", "left", "view=top,projection=orthographic"):
            where = view if "=" in view else "view=" + view
            rays = self.png("head.ply", camera=where, **camera).rows
            raster = self.png("head.ply", camera=where, visibility="raster", **camera).rows
            self.assertGreater(len(set(map(bytes, rays))), 20, "the picture is empty")
            differ = sum(a != b for p, q in zip(rays, raster) for a, b in zip(p, q))
            self.assertLessEqual(differ, 0.001 * 3 * 120 * 90)

    def test_raster_of_a_volume_says_that_it_draws_a_mesh(self):
        done = self.run_isolux("render", "phantom:sphere", "-o", "a.png", "--size", "64x64",
                               "--visibility", "raster")
        self.assertIn("drawn as meshes", done.stderr)

    def test_a_mesh_without_normals_is_smoothed_up_to_the_crease(self):
        self.cube()
        scene = {"size": "48x48", "camera": "eye=6:-7:8,target=0.5:0.5:0.5"}

        def normals(**options):
            picture = self.exr("cube.obj", **scene, **options)
            hits = [p for p in picture.pixels() if picture.at("surface.id", *p) == 0]
            return {tuple(round(picture.at("normal." + axis, *p), 4) for axis in "XYZ")
                    for p in hits}

        # The edges of a cube are bent by 90 degrees.
        self.assertEqual(normals(), {(1, 0, 0), (0, -1, 0), (0, 0, 1)})
        self.assertEqual(normals(crease=89), normals())
        self.assertGreater(len(normals(crease=91)), 50)
        self.run_isolux("mesh", "cube.obj", "smooth.ply", "--crease", "91")
        told = json.loads(self.run_isolux("info", "smooth.ply", "--json").stdout)
        self.assertEqual((told["vertices"], told["watertight"]), (8, True))
        # Its own normals are kept: there is nothing left to smooth.
        self.refused("render", "smooth.ply", "-o", "a.png", "--crease", "30", status=USAGE,
                     about="--crease")
        self.refused("render", "phantom:sphere", "-o", "a.png", "--crease", "30", status=USAGE,
                     about="--crease")

    def test_explain_tells_the_pixel_of_a_painted_mesh(self):
        (self.folder / "m.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n")
        (self.folder / "two.obj").write_text(
            "mtllib m.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nusemtl a\nf 1 2 3\n"
            "usemtl b\nf 1 3 4\n")
        light = {"light": "directional,to=0:-1:0", "size": "32x32"}
        picture = self.exr("two.obj", **light)
        reds = set()
        for pixel in ((18, 17), (13, 11)):
            told = self.explained("two.obj", pixel=pixel, **light)
            self.assert_near([picture.at(c, *pixel) for c in "RGB"], told["total"], 1e-5)
            reds.add(round(told["total"][0], 3))
        self.assertEqual(len(reds), 2, "both triangles, each in its colour")
        # kd of the file, since --surface does not name it; the quad faces the lamp.
        changed = self.explained("two.obj", pixel=(18, 17), surface="input=1,ka=0:0:0,ks=0:0:0",
                                 **light)
        self.assertIn(changed["total"], ([1, 0, 0], [0, 1, 0]))

    def test_again_makes_the_same_picture_of_a_mesh(self):
        self.run_isolux("mesh", "phantom:head,size=32", "head.glb", "--iso", "300")
        self.run_isolux("render", "head.glb", "-o", "a.png", "--size", "64x64", "--surface",
                        "input=1,ks=0:0:0")
        self.run_isolux("render", "--again", "a.png", "-o", "b.png")
        self.assertEqual(*((self.folder / n).read_bytes() for n in ("a.png", "b.png")))

    def test_damaged_meshes_are_refused(self):
        for name, data in (("a.ply", b"ply\n"), ("b.stl", b"solid x\nendsolid x\n"),
                           ("c.glb", b"glTF" + 20 * b"\xff"), ("d.obj", b"v 0 0 0\nf 1 2 9\n"),
                           ("e.gltf", b"{")):
            (self.folder / name).write_bytes(data)
            self.refused("info", name, status=WORK, about=name)


if __name__ == "__main__":
    unittest.main()
