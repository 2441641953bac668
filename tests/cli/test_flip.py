"""docs/flip.py, by which denoised pictures are judged, against what can be said beforehand."""
import sys
import unittest
from pathlib import Path

try:
    import numpy
except ImportError:
    print("skipped: numpy is not here")
    sys.exit(77)

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
import flip as judge  # noqa: E402


def flat(*srgb):
    return numpy.broadcast_to(numpy.array(srgb, float), (40, 40, 3))


class Flip(unittest.TestCase):
    def test_equal_pictures_do_not_differ(self):
        noise = numpy.random.default_rng(1).random((40, 40, 3))
        self.assertEqual(judge.flip(noise, noise).max(), 0)

    def test_green_and_blue_differ_by_1_and_no_order_matters(self):
        green, blue = flat(0, 1, 0), flat(0, 0, 1)
        for one, other in ((green, blue), (blue, green)):
            numpy.testing.assert_allclose(judge.flip(one, other), 1, atol=1e-9)

    def test_flat_greys_differ_by_their_lightness(self):
        # No chroma and no edges: HyAB is the difference in L*, of the byte 119 and black 50.03,
        # which lies below the knee: 0.95 / 0.4 (50.03 / largest)^0.7. The largest, green to blue:
        # L*a*b* 87.735, -86.183, 83.180 and 32.297, 79.188, -107.860, with a and b times L / 100.
        largest = 87.735 - 32.297 + numpy.hypot(-86.183 * 0.87735 - 79.188 * 0.32297,
                                                83.180 * 0.87735 + 107.860 * 0.32297)
        expected = 0.95 / 0.4 * (50.03 / largest) ** 0.7
        self.assertLess(expected, 0.95)
        found = judge.flip(flat(*3 * [119 / 255]), flat(0, 0, 0))
        numpy.testing.assert_allclose(found, expected, rtol=1e-3)

    def test_a_step_from_0_to_1_is_an_edge_of_strength_1(self):
        # The kernel's halves weigh 1 and -1, and its middle nothing.
        step = numpy.zeros((40, 40))
        step[:, 20:] = 1
        edges, points = judge.features(step)
        numpy.testing.assert_allclose(edges[:, 19:21], 1)
        numpy.testing.assert_allclose(edges[:, :5], 0, atol=1e-12)
        self.assertLess(points.max(), 1)

    def test_an_edge_counts_for_more_than_its_color_alone(self):
        step = numpy.zeros((40, 40, 3))
        step[:, 20:] = 0.3
        both = judge.flip(step, flat(0, 0, 0))
        opponents = [judge.opponent_from_linear(judge.linear_from_srgb(image))
                     for image in (step, flat(0, 0, 0))]
        color = judge.color_difference(*opponents)
        self.assertTrue((both[:, 20] > color[:, 20] + 0.05).all())
        numpy.testing.assert_allclose(both[:, 38], color[:, 38], atol=1e-9)


if __name__ == "__main__":
    unittest.main()
