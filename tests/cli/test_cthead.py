"""The lecture's worked example: the CT head of 256 x 256 x 113 voxels, a lamp at voxel (0, 0, 57)
whose x is on a slider, from the NRRD header over the 113 slices and from the bare voxels."""

import unittest

from closed_form import dot, length, scale, sub
from isolux import SHARED, TestCase, needs_shared

HEADER = SHARED / "data" / "cthead" / "CThead.nhdr"
SLIDER = (0, 128, 255)
RAW = {"dims": "256x256x113", "type": "i16be", "spacing": "1:1:2"}
# One pixel for every second voxel column, seen from the face (y = 0, at -y).
COLUMNS = {"size": "128x113", "camera": "view=front,projection=orthographic,height=226",
           "surface": "iso=600,ks=0:0:0"}


def lamp(x):
    return f"point,at={x}:0:57,space=index"


@needs_shared
class CTHead(TestCase):
    def setUp(self):
        super().setUp()
        slices = [(HEADER.parent / f"CThead.{n}").read_bytes() for n in range(1, 114)]
        (self.folder / "CThead.raw").write_bytes(b"".join(slices))

    def test_the_lamps_vector_is_that_of_the_loops(self):
        # With --spacing 1:1:1 world space is index space, so L = (x - i, 0 - j, 57 - k).
        for x in SLIDER:
            exr = self.exr("CThead.raw", **{**RAW, **COLUMNS, "spacing": "1:1:1"}, light=lamp(x))
            self.assertGreater(len(exr.hits()), 2000)
            for pixel in exr.hits():
                normal = exr.triple("normal", *pixel)
                to_lamp = sub((x, 0, 57), exr.triple("position", *pixel))
                cosine = dot(normal, scale(1 / length(to_lamp), to_lamp))
                # Normals and positions are floats: some 1e-5 of 256 voxels, over the distance.
                self.assert_near(exr.at("diffuse.G", *pixel), 0.8 * max(0, cosine), 1e-4, 1e-5)

    def test_the_light_moves_across_the_face_with_the_slider(self):
        middles = []
        for x in SLIDER:
            exr = self.exr(HEADER, **COLUMNS, light=lamp(x))
            weights = [(exr.at("diffuse.G", *pixel), pixel[0]) for pixel in exr.hits()]
            middles.append(sum(w * column for w, column in weights) / sum(w for w, _ in weights))
        self.assertEqual(middles, sorted(middles))
        self.assertGreater(middles[2] - middles[0], 10)  # columns, of the 128

    def test_the_bare_voxels_and_the_header_show_the_same_head(self):
        # The header turns k down (slice 1 is the top of the skull); bare voxels run k up. So the
        # one is the other upside down, its rows in reverse order.
        for x in SLIDER:
            upright = self.png(HEADER, **COLUMNS, light=lamp(x))
            upside_down = self.png("CThead.raw", **RAW, **COLUMNS, light=lamp(x))
            self.assertTrue(upright.rows == upside_down.rows[::-1], f"lamp at x = {x}")


if __name__ == "__main__":
    unittest.main()
