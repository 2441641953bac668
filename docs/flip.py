"""How different two pictures look when one flips to the other: FLIP, in numpy.

Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, "FLIP: A Difference Evaluator
for Alternating Images" (Proc. ACM Comput. Graph. Interact. Tech. 3(2)), for displayed pictures, from
the formulas of the paper. 0: equal; 1: as far apart as green and blue.
"""

from math import ceil, pi, sqrt

import numpy

# A screen of 3840 pixels and 0.7 m, seen from 0.7 m.
PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * pi / 180

XYZ_FROM_RGB = numpy.array([[0.4124564, 0.3575761, 0.1804375],
                            [0.2126729, 0.7151522, 0.0721750],
                            [0.0193339, 0.1191920, 0.9503041]])
WHITE = XYZ_FROM_RGB.sum(axis=1)

# Contrast sensitivity of luminance, red-green and blue-yellow: Gaussians (a, b), the Fourier
# transform of which is a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
SENSITIVITY = ([(1, 0.0047)], [(1, 0.0053)], [(34.1, 0.04), (13.5, 0.025)])

COLOR_EXPONENT, FEATURE_EXPONENT = 0.7, 0.5
KNEE_AT, KNEE = 0.4, 0.95  # differences up to this share of the largest take most of the range
FEATURE_DEGREES = 0.082


def linear_from_srgb(srgb):
    return numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def opponent_from_linear(rgb):
    """Yy, Cx, Cz: a linear form of L*a*b*, in which the eye's blur may be computed."""
    x, y, z = numpy.moveaxis(rgb @ XYZ_FROM_RGB.T / WHITE, -1, 0)
    return numpy.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def linear_from_opponent(opponent):
    yy, cx, cz = numpy.moveaxis(opponent, -1, 0)
    y = (yy + 16) / 116
    xyz = numpy.stack([cx / 500 + y, y, y - cz / 200], axis=-1)
    return xyz * WHITE @ numpy.linalg.inv(XYZ_FROM_RGB).T


def hunt_lab_from_linear(rgb):
    """L*a*b*, with less chroma where it is dark (Hunt's effect)."""
    t = rgb @ XYZ_FROM_RGB.T / WHITE
    edge = 6 / 29
    x, y, z = numpy.moveaxis(
        numpy.where(t > edge ** 3, numpy.cbrt(t), t / (3 * edge ** 2) + 4 / 29), -1, 0)
    lightness = 116 * y - 16
    return numpy.stack([lightness, 0.01 * lightness * 500 * (x - y),
                        0.01 * lightness * 200 * (y - z)], axis=-1)


def convolved(image, along_y, along_x):
    """With the product of two odd kernels; the border's pixels go on beyond it."""
    for axis, kernel in ((0, along_y), (1, along_x)):
        radius, length = len(kernel) // 2, image.shape[axis]
        margins = [(radius, radius) if a == axis else (0, 0) for a in (0, 1)]
        padded = numpy.pad(image, margins, mode="edge")
        image = sum(weight * padded.take(range(n, n + length), axis)
                    for n, weight in enumerate(kernel))
    return image


def seen(opponent):
    """What the eye resolves of it, as linear RGB."""
    widest = max(b for gaussians in SENSITIVITY for _, b in gaussians)
    radius = ceil(3 * sqrt(widest / (2 * pi ** 2)) * PIXELS_PER_DEGREE)
    x = numpy.arange(-radius, radius + 1) / PIXELS_PER_DEGREE
    channels = []
    for channel, gaussians in zip(numpy.moveaxis(opponent, -1, 0), SENSITIVITY):
        total, weight = 0, 0
        for a, b in gaussians:
            kernel = numpy.exp(-pi ** 2 * x ** 2 / b)
            scale = a * sqrt(pi / b)
            total = total + scale * convolved(channel, kernel, kernel)
            weight += scale * kernel.sum() ** 2
        channels.append(total / weight)
    return linear_from_opponent(numpy.stack(channels, axis=-1)).clip(0, 1)


def hyab(lab, other):
    off = lab - other
    return abs(off[..., 0]) + numpy.hypot(off[..., 1], off[..., 2])


def color_difference(opponent, other):
    green, blue = hunt_lab_from_linear(numpy.array([[0.0, 1, 0], [0, 0, 1]]))
    largest = hyab(green, blue) ** COLOR_EXPONENT
    labs = [hunt_lab_from_linear(seen(image)) for image in (opponent, other)]
    off = hyab(*labs) ** COLOR_EXPONENT
    knee = KNEE_AT * largest
    return numpy.where(off < knee, KNEE / knee * off,
                       KNEE + (off - knee) / (largest - knee) * (1 - KNEE))


def features(luminance):
    """How strong edges and points are."""
    sigma = 0.5 * FEATURE_DEGREES * PIXELS_PER_DEGREE
    radius = ceil(3 * sigma)
    x = numpy.arange(-radius, radius + 1)
    smooth = numpy.exp(-x ** 2 / (2 * sigma ** 2))

    def strength(kernel):
        parts = kernel.clip(min=0), kernel.clip(max=0)
        kernel = sum(part / abs(part.sum()) for part in parts)  # 1 and -1 beside each other
        even = smooth / smooth.sum()
        return numpy.hypot(convolved(luminance, even, kernel), convolved(luminance, kernel, even))

    return strength(-x * smooth), strength((x ** 2 / sigma ** 2 - 1) * smooth)


def feature_difference(opponent, other):
    (edges, points), (other_edges, other_points) = (
        features((image[..., 0] + 16) / 116) for image in (opponent, other))
    off = numpy.maximum(abs(edges - other_edges), abs(points - other_points))
    return (off / sqrt(2)) ** FEATURE_EXPONENT


def flip(picture, reference):
    """The difference at each pixel, of two pictures of sRGB values from 0 to 1, [y, x, channel]."""
    images = [opponent_from_linear(linear_from_srgb(image)) for image in (picture, reference)]
    return color_difference(*images) ** (1 - feature_difference(*images))
