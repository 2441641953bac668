"""The contract's sums once more, in plain Python: vectors, camera rays, the reflection model."""

import math


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scale(s, a):
    return tuple(s * x for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def unit(a):
    return scale(1 / length(a), a)


def apply(columns, v):
    """The matrix with these columns, times v."""
    return tuple(sum(column[row] * x for column, x in zip(columns, v)) for row in range(3))


def inverse_transpose(columns):
    """Its columns are the cross products of the others, over the determinant."""
    a, b, c = columns
    det = dot(a, cross(b, c))
    return [scale(1 / det, v) for v in (cross(b, c), cross(c, a), cross(a, b))]


class Camera:
    """Section 6: the eye ray passes through the pixel's centre, row 0 is the top."""

    def __init__(self, eye, target, up, width, height, fov=None, height_mm=None):
        self.eye, self.width, self.height, self.fov = eye, width, height, fov
        self.back = unit(sub(eye, target))
        self.right = unit(cross(up, self.back))
        self.up = cross(self.back, self.right)
        self.half = height_mm / 2 if height_mm else math.tan(math.radians(fov) / 2)

    def ray(self, x, y):
        """Origin and unit direction."""
        pixel = 2 * self.half / self.height
        across = add(scale((x + 0.5 - self.width / 2) * pixel, self.right),
                     scale((self.height / 2 - y - 0.5) * pixel, self.up))
        if self.fov is None:
            return add(self.eye, across), scale(-1, self.back)
        return self.eye, unit(sub(across, self.back))

    def world(self, v):
        """A vector of camera space in the world."""
        return add(add(scale(v[0], self.right), scale(v[1], self.up)), scale(v[2], self.back))


def light_terms(p, n, e, light, kd, ks, shininess):
    """Section 4: diffuse and specular of one light {"at" or "to", "color", "falloff" in mm}."""
    offset = sub(light["at"], p) if "at" in light else light["to"]
    l = unit(offset)
    cos_theta = dot(n, l)
    if cos_theta <= 0:
        return (0, 0, 0), (0, 0, 0)
    r = sub(scale(2 * cos_theta, n), l)
    weakened = (light["falloff"] / length(offset)) ** 2 if "falloff" in light else 1
    phong = max(0, dot(r, e)) ** shininess
    diffuse = tuple(k * i * cos_theta * weakened for k, i in zip(kd, light["color"]))
    specular = tuple(k * i * phong * weakened for k, i in zip(ks, light["color"]))
    return diffuse, specular


def srgb(x):
    """The sRGB transfer function (IEC 61966-2-1)."""
    return 12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055


def shown(radiance, exposure=1, curve=srgb):
    """Section 5: a byte, rounded to nearest."""
    return math.floor(255 * min(1, max(0, curve(exposure * radiance))) + 0.5)


def text(v):
    """A vector or colour as the command line takes it."""
    return ":".join(repr(float(x)) for x in v)
