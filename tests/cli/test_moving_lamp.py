"""Indirect light while a lamp moves: cached transport does not flicker on a real skull."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from isolux import PROGRAM, listed
from pictures import read_exr

KD = 0.8  # of surfaces, when nothing is said
BOUNCES = 2
STEPS = 10
# Near an orbit and the hole in the forehead: creases, thin bone, edges of shadows.
LOOK = listed({"size": "192x192", "surface": "iso=300", "shadows": "on", "indirect": "transport",
               "bounces": BOUNCES, "camera": "eye=-60:-620:190,target=90:-230:70,fov=5"})
HAS_SCAN = "phantom" not in subprocess.run([PROGRAM, "info"], capture_output=True,
                                           text=True).stdout


def mean(numbers):
    numbers = list(numbers)
    return sum(numbers) / len(numbers)


def frames():
    """The lamp moves by 1 mm a step, some 450 mm away: each frame's numbers where surfaces are."""
    with tempfile.TemporaryDirectory(prefix="isolux-test-") as folder:
        for step in range(STEPS + 1):
            path = Path(folder) / "frame.exr"
            subprocess.run([PROGRAM, "render", *LOOK, "--light", f"point,at={-120 + step}:-560:260",
                            "-o", path], check=True, stderr=subprocess.DEVNULL)
            exr = read_exr(path)
            yield {name: [exr.at(name, x, y) for x, y in exr.hits()]
                   for name in ("indirect.G", "diffuse.G", "sky.Y")}


@unittest.skipUnless(HAS_SCAN, "the CT head (Debian's package invesalius-examples) is not here")
@unittest.skipIf("ASAN_OPTIONS" in os.environ, "sanitizers make minutes of it")
class MovingLamp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = list(frames())

    def changes(self):
        """For each frame between two others: how much each pixel departs from going on evenly."""
        light = [frame["indirect.G"] for frame in self.frames]
        return [[abs(after - 2 * now + before)
                 for before, now, after in zip(*light[k - 1:k + 2])] for k in range(1, STEPS)]

    def passed_by_edges(self, k):
        """Direct light that goes into a shadow or comes out of one by frame k, over all pixels."""
        before, now = (frame["diffuse.G"] for frame in self.frames[k - 1:k + 1])
        return mean(abs(a - b) if (a > 0) != (b > 0) else 0 for a, b in zip(before, now))

    def test_indirect_light_changes_by_no_more_than_the_senders_do_whose_shadows_end(self):
        # Light that goes on evenly departs by nothing: cosines of lamps R = 450 mm away by less
        # than (1 mm / R)^2 = 5e-6. What is left are senders that a shadow's edge passes. They lose
        # or gain as much as what is seen, p in this step and p' in the next; a pixel sees surface
        # in 1 - sky of its directions and sends kd of it on, and so on for each bounce. A change in
        # one step is a departure in two frames.
        received = KD * (1 - mean(self.frames[0]["sky.Y"]))
        sent_on = sum(received ** bounce for bounce in range(1, BOUNCES + 1))
        for k, changes in enumerate(self.changes(), 1):
            passed = self.passed_by_edges(k) + self.passed_by_edges(k + 1)
            self.assertLessEqual(mean(changes), sent_on * passed + 5e-6, f"frame {k}")

    def test_no_pixel_flickers(self):
        # One sample of 2 cells a side hides by its turning dark what it covers of a pixel's
        # hemisphere: (2 * 0.96 mm)^2 / (pi d^2) at a distance d, a tenth at d = 3.4 mm. Nearer lit
        # senders than that are rare: one pixel in a hundred may depart by more than a tenth of the
        # light that it has and the picture has on average, none in any frame by all of it.
        for k, changes in enumerate(self.changes(), 1):
            light = self.frames[k]["indirect.G"]
            average = mean(light)
            shares = sorted(change / (own + average) for change, own in zip(changes, light))
            self.assertLessEqual(shares[int(0.99 * len(shares))], 0.1, f"frame {k}")
            self.assertLessEqual(shares[-1], 1, f"frame {k}")


if __name__ == "__main__":
    unittest.main()
