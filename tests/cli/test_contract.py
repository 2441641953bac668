"""The meaning of every number in a picture, against closed forms (contract, sections 1 to 7)."""

import json
import math
import unittest

from closed_form import (Camera, add, apply, cross, dot, inverse_transpose, length, light_terms,
                         scale, shown, srgb, sub, text, unit)
from isolux import TestCase
from pictures import BLOB_DIMS, blob, grid, write_nrrd

CHANNELS = sorted(
    ["R", "G", "B", "A", "depth.Z", "surface.id"]
    + [f"{layer}.{c}" for layer in ("ambient", "diffuse", "specular", "indirect", "mirror")
       for c in "RGB"]
    + [f"{layer}.{c}" for layer in ("normal", "position") for c in "XYZ"])


def matte(**fields):
    """A surface of the diffuse term alone, but for what is given."""
    fields = {"iso": 0, "ka": "0:0:0", "kd": "1:1:1", "ks": "0:0:0", **fields}
    return ",".join(f"{k}={v}" for k, v in fields.items())


class WhatAnExrHolds(TestCase):
    def test_channels_are_those_of_the_contract(self):
        exr = self.exr("phantom:sphere", size="16x16", surface="iso=0.5")
        self.assertEqual(sorted(exr.channels), CHANNELS)
        self.assertIn(exr.attributes["compression"][1][0], (0, 2, 3))

    def test_nothing_hit_is_background_no_coverage_infinite_depth_and_zero_elsewhere(self):
        exr = self.exr("phantom:sphere", size="24x24", surface="iso=0.5", background="0.25:0.5:2")
        missed = set(exr.pixels()) - set(exr.hits())
        self.assertTrue(missed and exr.hits())
        special = {"R": 0.25, "G": 0.5, "B": 2, "depth.Z": math.inf, "surface.id": -1}
        for x, y in missed:
            for name in CHANNELS:
                self.assertEqual(exr.at(name, x, y), special.get(name, 0), name)

    def test_there_is_no_nan_and_coverage_is_one_where_something_is_hit(self):
        exr = self.exr("phantom:marschner-lobb", size="32x32", surface="iso=0.5")
        for name in CHANNELS:
            self.assertFalse(any(map(math.isnan, exr.channels[name])), name)
        self.assertTrue(exr.hits())
        self.assertTrue(all(exr.at("A", x, y) == 1 for x, y in exr.hits()))

    def test_radiance_is_the_sum_of_its_terms_and_not_clamped(self):
        exr = self.exr("phantom:sphere", size="24x24", surface="iso=0.5",
                       light="directional,to=1:-2:1,intensity=7")
        for x, y in exr.hits():
            terms = [exr.triple(t, x, y)
                     for t in ("ambient", "diffuse", "specular", "indirect", "mirror")]
            self.assert_near(exr.triple("", x, y), [sum(c) for c in zip(*terms)], 1e-6)
        self.assertGreater(max(exr.channels["R"]), 5)

    def test_surfaces_are_counted_from_0_in_the_order_of_their_options(self):
        exr = self.exr("phantom:sphere", size="24x24", surface=["iso=0.75", "iso=0.25"])
        self.assertEqual(set(exr.channels["surface.id"]), {-1, 1})  # the inner one is hidden


class Sphere(TestCase):
    """phantom:sphere at 0.5: radius 16 mm. Between voxels 1 mm apart a linear interpolant of |p| is
    off by at most 1/8 of the sum of the second derivatives, 2/|p|: 1/64 mm."""

    RADIUS, OFF = 16, 1 / 64

    def test_hits_lie_on_the_sphere_with_its_normals(self):
        exr = self.exr("phantom:sphere", size="40x40", surface="iso=0.5",
                       camera="eye=60:-80:50,target=0:0:0,fov=25")
        camera = Camera((60, -80, 50), (0, 0, 0), (0, 0, 1), 40, 40, fov=25)
        for x, y in exr.pixels():
            eye, d = camera.ray(x, y)
            closest = length(sub(eye, scale(dot(eye, d), d)))
            hit = exr.at("surface.id", x, y) >= 0
            if abs(closest - self.RADIUS) > self.OFF:
                self.assertEqual(hit, closest < self.RADIUS)
            if not hit:
                continue
            p = exr.triple("position", x, y)
            self.assert_near(length(p), self.RADIUS, 0, self.OFF)
            self.assert_near(exr.at("depth.Z", x, y), length(sub(p, eye)), 1e-5)
            self.assertGreater(dot(exr.triple("normal", x, y), unit(p)),
                               math.cos(math.radians(0.5)))

    def test_the_headlight_lights_a_sphere_by_its_cosine(self):
        exr = self.exr("phantom:sphere", size="32x32", surface=matte(iso=0.5),
                       camera="view=front,projection=orthographic,height=40")
        for x, y in exr.hits():
            self.assert_near(exr.at("R", x, y), -exr.triple("normal", x, y)[1], 1e-5)


class SlantedPlane(TestCase):
    """A linear field on a grid that is turned, stretched and sheared: hits, normals and terms are
    exact, since the trilinear interpolant and central differences reproduce a linear field."""

    DIMS, SLOPE, ISO = (20, 16, 12), (3, -2, 5), 41.25
    # Hamilton's quaternion (1, 2, 3, 4) / sqrt 30 as columns, times the spacings; k is sheared.
    TURN = [(-20 / 30, 20 / 30, 10 / 30), (4 / 30, -10 / 30, 28 / 30), (22 / 30, 20 / 30, 4 / 30)]
    STEPS = [scale(0.7, TURN[0]), scale(1.3, TURN[1]),
             add(scale(2.1, TURN[2]), scale(0.2, TURN[0]))]
    ORIGIN = (-30, 12, 45)
    NORMAL = unit(scale(-1, apply(inverse_transpose(STEPS), SLOPE)))
    SIZE = (36, 28)

    def setUp(self):
        super().setUp()
        values = grid(self.DIMS, lambda *index: round(dot(self.SLOPE, index)))
        write_nrrd(self.folder / "plane.nrrd", self.DIMS, values,
                   directions=self.STEPS, origin=self.ORIGIN)
        self.middle = self.world([(n - 1) / 2 for n in self.DIMS])
        aside = unit(cross(self.NORMAL, (0, 0, 1)))
        self.eye = add(self.middle, add(scale(40, self.NORMAL), scale(15, aside)))
        self.camera = Camera(self.eye, self.middle, (0.2, 0.1, 1), *self.SIZE, fov=28)

    def world(self, index):
        return add(self.ORIGIN, apply(self.STEPS, index))

    def plane(self, **options):
        camera = f"eye={text(self.eye)},target={text(self.middle)},up=0.2:0.1:1,fov=28"
        return self.exr("plane.nrrd", size="%dx%d" % self.SIZE, camera=camera, **options)

    def hit(self, x, y):
        """The point of the plane on a pixel's ray, and how far inside the box (in voxels)."""
        eye, d = self.camera.ray(x, y)
        rows = inverse_transpose(self.STEPS)
        to_index = lambda v: tuple(dot(row, v) for row in rows)
        at_eye = dot(self.SLOPE, to_index(sub(eye, self.ORIGIN)))
        t = (self.ISO - at_eye) / dot(self.SLOPE, to_index(d))
        p = add(eye, scale(t, d))
        index = to_index(sub(p, self.ORIGIN))
        return p, min(min(i, n - 1 - i) for i, n in zip(index, self.DIMS))

    def test_hits_normals_and_depths_are_those_of_the_plane_and_end_with_the_box(self):
        exr = self.plane(surface=f"iso={self.ISO}")
        self.assertTrue(exr.hits())
        for x, y in exr.pixels():
            p, inside = self.hit(x, y)
            if abs(inside) < 1e-6:
                continue
            self.assertEqual(exr.at("surface.id", x, y) >= 0, inside > 0, (x, y))
            if inside > 0:
                self.assert_near(exr.triple("position", x, y), p, 1e-6, 1e-5)
                self.assert_near(exr.at("depth.Z", x, y), length(sub(p, self.eye)), 1e-6)
                self.assert_near(exr.triple("normal", x, y), self.NORMAL, 1e-5)

    def test_every_term_is_that_of_the_reflection_model(self):
        ka, kd, ks, shininess = (0.1, 0.2, 0.3), (0.9, 0.5, 0.25), (0.2, 0.6, 1), 17
        above = self.world((4, 3, 2))
        lamp = add(self.middle, add(scale(25, self.NORMAL), (5, -8, 3)))
        to = add(self.NORMAL, (0.5, 0.2, -0.4))
        given = [
            (f"point,at={text(lamp)},color=1:0.5:0.25,intensity=3",
             {"at": lamp, "color": (3, 1.5, 0.75)}),
            (f"directional,to={text(scale(9, to))},color=0.2:0.4:0.8",
             {"to": to, "color": (0.2, 0.4, 0.8)}),
            (f"point,at={text(lamp)},falloff=inverse-square,reference=30",
             {"at": lamp, "color": (1, 1, 1), "falloff": 30}),
            ("point,at=4:3:2,space=index", {"at": above, "color": (1, 1, 1)}),
            ("point,at=7:6:-5,attach=camera",
             {"at": add(self.eye, self.camera.world((7, 6, -5))), "color": (1, 1, 1)}),
            ("directional,to=-1:2:3,attach=camera,color=2:1:0",
             {"to": self.camera.world((-1, 2, 3)), "color": (2, 1, 0)}),
        ]
        exr = self.plane(light=[g for g, _ in given],
                         surface=f"iso={self.ISO},ka={text(ka)},kd={text(kd)},ks={text(ks)},"
                                 f"shininess={shininess}")
        sum_of_intensities = [sum(c) for c in zip(*(light["color"] for _, light in given))]
        for x, y in exr.hits():
            p, _ = self.hit(x, y)
            e = unit(sub(self.eye, p))
            terms = [light_terms(p, self.NORMAL, e, light, kd, ks, shininess) for _, light in given]
            ambient = [k * i for k, i in zip(ka, sum_of_intensities)]
            diffuse = [sum(c) for c in zip(*(t[0] for t in terms))]
            specular = [sum(c) for c in zip(*(t[1] for t in terms))]
            self.assert_near(exr.triple("ambient", x, y), ambient)
            self.assert_near(exr.triple("diffuse", x, y), diffuse)
            self.assert_near(exr.triple("specular", x, y), specular)
            self.assert_near(exr.triple("", x, y),
                             [sum(c) for c in zip(ambient, diffuse, specular)])

    def test_index_camera_and_world_space_name_the_same_place(self):
        def lit(light):
            return self.plane(surface=f"iso={self.ISO}", light=light)
        in_camera, in_index = (3, -4, -20), (5, 9, 14)
        pairs = [
            ("point,attach=camera,at=" + text(in_camera),
             "point,at=" + text(add(self.eye, self.camera.world(in_camera)))),
            ("point,space=index,at=" + text(in_index), "point,at=" + text(self.world(in_index))),
            ("directional,space=index,to=" + text(in_index),
             "directional,to=" + text(apply(self.STEPS, in_index))),
            ("directional,attach=camera,to=0:0:1", "directional,to=" + text(self.camera.back)),
        ]
        for one, other in pairs:
            a, b = lit(one), lit(other)
            self.assertGreater(max(a.channels["R"]), 0.1, one)
            self.assert_near(a.channels["R"], b.channels["R"], 1e-5, 1e-6, one)


class FacingWall(TestCase):
    """A field that grows with y alone: at 0 a wall through the origin that faces the eye in front,
    seen without perspective, so that n = e = (0, -1, 0) everywhere."""

    VIEW = "view=front,projection=orthographic,height=6"

    def setUp(self):
        super().setUp()
        write_nrrd(self.folder / "wall.nrrd", (9, 9, 9), grid((9, 9, 9), lambda i, j, k: j - 4),
                   directions=[(1, 0, 0), (0, 1, 0), (0, 0, 1)], origin=(-4, -4, -4))

    def wall(self, **options):
        return self.exr("wall.nrrd", **{"size": "3x3", "camera": self.VIEW, **options})

    def middle(self, layer="", **options):
        """A layer's number in the middle of the picture, on the ray through the origin."""
        return self.wall(**options).triple(layer, 1, 1)

    def test_lambert_cosine_law(self):
        for degrees in (0, 30, 45, 60, 90):
            angle = math.radians(degrees)
            light = f"directional,to={math.sin(angle)}:{-math.cos(angle)}:0"
            self.assert_near(self.middle(surface=matte(), light=light), [math.cos(angle)] * 3,
                             message=f"{degrees} degrees")

    def test_length_of_the_vector_to_a_directional_light_does_not_matter(self):
        one, other = (self.middle(light=f"directional,to={v}") for v in ("1:-2:3", "10:-20:30"))
        self.assert_near(one, other, 1e-6)

    def test_lamp_colour_times_surface_colour_in_each_channel(self):
        found = self.middle(surface=matte(kd="0.5:0.25:1"),
                            light="directional,to=0:-1:0,color=1:2:0.5,intensity=3")
        self.assert_near(found, (0.5 * 3, 0.25 * 6, 1 * 1.5), 1e-6)

    def test_white_light_on_a_red_surface_is_red(self):
        found = self.middle(surface=matte(kd="1:0:0"), light="directional,to=0:-1:0")
        self.assert_near(found, (1, 0, 0), 1e-6, 0)

    def test_blue_light_on_a_red_surface_is_black(self):
        found = self.middle(surface=matte(kd="1:0:0"), light="directional,to=0:-1:0,color=0:0:1")
        self.assertEqual(found, (0, 0, 0))

    def test_a_lamp_behind_the_surface_adds_nothing(self):
        for light in ("directional,to=0.3:1:0", "point,at=1:3:1"):
            exr = self.wall(surface="iso=0,ka=0:0:0,shininess=0", light=light)
            self.assertEqual(set(exr.channels["R"]), {0.0}, light)

    def test_a_highlight_needs_the_lamp_in_front_even_where_r_meets_the_eye(self):
        # l dips 0.6 degrees below the wall, away from the eye: r = -l nearly, and r · e > 0.9.
        seen = self.explained("wall.nrrd", pixel=(1, 1), size="3x3", surface=matte(ks="1:1:1"),
                              light="directional,to=1:0.01:0", camera="eye=-20:-6:0,target=0:0:0")
        self.assertLess(seen["lights"][0]["cos_theta"], 0)
        self.assertGreater(seen["lights"][0]["cos_phi"], 0.9)
        self.assertEqual(seen["lights"][0]["specular"], [0, 0, 0])

    def test_lighting_is_two_sided(self):
        seen = self.explained("wall.nrrd", pixel=(1, 1), size="3x3", surface=matte(),
                              light="directional,to=0:1:0",
                              camera="view=back,projection=orthographic,height=6")
        self.assert_near(seen["normal"], (0, 1, 0))
        self.assert_near(seen["total"], (1, 1, 1))

    def test_phong_lobe_narrows_with_shininess(self):
        # n = e, so the angle between r and e is the lamp's own.
        angle = math.radians(10)
        light = f"directional,to={math.sin(angle)}:{-math.cos(angle)}:0"
        for shininess in (1, 10, 100, 1000):
            found = self.middle(surface=matte(kd="0:0:0", ks="0.5:0.25:1", shininess=shininess),
                                light=light)
            lobe = math.cos(angle) ** shininess
            self.assert_near(found, (0.5 * lobe, 0.25 * lobe, lobe), 1e-4, 0)

    def test_shininess_0_is_a_highlight_everywhere_in_front(self):
        found = self.middle(surface=matte(kd="0:0:0", ks="0.5:0.5:0.5", shininess=0),
                            light="directional,to=3:-1:0")
        self.assert_near(found, [0.5] * 3)

    def test_several_lamps_are_the_sum_of_single_lamps(self):
        lamps = ["point,at=3:-5:2,color=1:0.2:0.1", "directional,to=-1:-1:1,intensity=2",
                 "point,at=-8:-2:0,falloff=inverse-square,reference=5"]
        alone = [self.wall(light=lamp) for lamp in lamps]
        together = self.wall(light=lamps)
        for channel in ("R", "G", "B", "ambient.R", "diffuse.G", "specular.B"):
            wanted = [sum(values) for values in zip(*(exr.channels[channel] for exr in alone))]
            self.assert_near(together.channels[channel], wanted, 1e-5)

    def test_ambient_light_is_the_sum_of_intensities_unless_given(self):
        lights = ["directional,to=0:-1:0,color=1:0.5:0,intensity=2", "point,at=0:-9:0,color=0:1:3"]
        surface = matte(ka="0.5:0.5:0.1")
        self.assert_near(self.middle("ambient", surface=surface, light=lights),
                         (0.5 * 2, 0.5 * 2, 0.1 * 3), 1e-6)
        self.assert_near(self.middle("ambient", surface=surface, light=lights, ambient="4:0:1"),
                         (2, 0, 0.1), 1e-6)

    def test_without_lights_one_headlight_shines(self):
        # ka + kd + ks of the defaults, straight on.
        self.assert_near(self.middle(surface="iso=0"), [0.1 + 0.8 + 0.3] * 3, 1e-6)

    def test_inverse_square_falloff_is_one_at_the_reference_distance(self):
        def at(distance, *more):
            light = ",".join([f"point,at=0:{-distance}:0", *more])
            return self.middle(surface=matte(), light=light)[0]
        self.assert_near(at(50), 1)
        self.assert_near(at(50, "falloff=inverse-square,reference=50"), 1)
        self.assert_near(at(100, "falloff=inverse-square,reference=50"), 0.25)
        self.assert_near(at(50, "falloff=inverse-square"), (1000 / 50) ** 2)

    def test_index_space_is_that_of_the_input_named(self):
        write_nrrd(self.folder / "other.nrrd", (2, 2, 2), [0, 1] * 4,
                   directions=[(2, 0, 0), (0, 3, 0), (0, 0, 5)], origin=(0, 20, 0))
        def lit(light):
            return self.exr("wall.nrrd", "other.nrrd", size="5x5", camera=self.VIEW,
                            surface="iso=0", light=light).channels["R"]
        # voxel (1, -9, 1) of the other: (2, 20 - 27, 5)
        self.assert_near(lit("point,at=1:-9:1,space=index,input=2"), lit("point,at=2:-7:5"), 1e-6)
        self.assert_near(lit("point,at=1:-9:1,space=index"), lit("point,at=-3:-13:-3"), 1e-6)

    def test_orthographic_height_and_pixel_centres(self):
        exr = self.wall(size="6x4", surface="iso=0",
                        camera="view=front,projection=orthographic,height=2")
        pixel = 2 / 4  # mm: the picture's height over its rows
        for x, y in exr.pixels():
            self.assert_near(exr.triple("position", x, y),
                             ((x + 0.5 - 3) * pixel, 0, (2 - y - 0.5) * pixel), 1e-6)
            self.assert_near(exr.triple("normal", x, y), (0, -1, 0))

    def test_rays_start_at_the_eye(self):
        # From inside, looking away from the wall, there is nothing.
        exr = self.wall(camera="eye=0:-2:0,target=0:-3:0")
        self.assertFalse(exr.hits())

    def test_png_bytes_follow_from_the_exr(self):
        scene = {"size": "16x16", "surface": "iso=0,shininess=3", "background": "0.1:0.002:0.7",
                 "light": "point,at=2:-3:1,color=1:0.5:0.02", "ambient": "0.01:0:0",
                 "camera": "view=front,projection=orthographic,height=12"}
        exr = self.wall(**scene)
        self.assertTrue(0 < len(exr.hits()) < 256)
        for exposure in (1, 0.25, 3):
            for name, curve in (("srgb", srgb), ("raw", lambda x: x)):
                png = self.png("wall.nrrd", display=name, exposure=exposure, **scene)
                for x, y in exr.pixels():
                    wanted = tuple(shown(c, exposure, curve) for c in exr.triple("", x, y))
                    self.assertEqual(png.at(x, y), wanted, (name, exposure, x, y))

    def test_srgb_is_the_default_display(self):
        scene = {"size": "8x8", "surface": "iso=0", "light": "point,at=2:-3:1"}
        self.assertEqual(self.png("wall.nrrd", **scene).rows,
                         self.png("wall.nrrd", display="srgb", exposure=1, **scene).rows)


class Cameras(TestCase):
    """Around phantom:sphere, whose box has corners 32 mm off along each axis."""

    BOUND = 32 * math.sqrt(3)
    # view: from the target towards the eye, and up (LPS)
    VIEWS = {"front": ((0, -1, 0), (0, 0, 1)), "back": ((0, 1, 0), (0, 0, 1)),
             "left": ((1, 0, 0), (0, 0, 1)), "right": ((-1, 0, 0), (0, 0, 1)),
             "top": ((0, 0, 1), (0, -1, 0)), "bottom": ((0, 0, -1), (0, -1, 0))}

    def test_named_views_look_from_their_side_and_fit_the_bounding_sphere(self):
        distance = self.BOUND / math.sin(math.radians(15))  # the half of fov 30 touches the sphere
        for view, (back, up) in self.VIEWS.items():
            camera = Camera(scale(distance, back), (0, 0, 0), up, 20, 20, fov=30)
            exr = self.exr("phantom:sphere", size="20x20", surface="iso=0.25",
                           camera=f"view={view}")
            self.assertTrue(exr.hits())
            for x, y in exr.hits():
                eye, d = camera.ray(x, y)
                p = add(eye, scale(exr.at("depth.Z", x, y), d))
                self.assert_near(exr.triple("position", x, y), p, 1e-5, 1e-4, view)

    def test_from_the_front_the_patients_left_is_on_the_right_of_the_picture(self):
        exr = self.exr("phantom:sphere", size="9x9", surface="iso=0.25")
        self.assertGreater(exr.at("position.X", 5, 4), 1)   # +x: the patient's left
        self.assertGreater(exr.at("position.Z", 4, 3), 1)   # +z: superior
        self.assertLess(exr.at("position.Y", 4, 4), -1)     # -y: anterior, toward the eye

    def test_portrait_and_landscape_fit_the_narrower_side_and_keep_pixels_square(self):
        for width, height in ((20, 40), (40, 20)):
            narrow = math.tan(math.radians(15)) * min(1, width / height)
            distance = self.BOUND / math.sin(math.atan(narrow))
            camera = Camera((0, -distance, 0), (0, 0, 0), (0, 0, 1), width, height, fov=30)
            for x, y in ((width // 2, height // 2), (width // 2 + 2, height // 2 - 3)):
                seen = self.explained("phantom:sphere", pixel=(x, y), size=f"{width}x{height}",
                                      surface="iso=0.25")
                eye, d = camera.ray(x, y)
                self.assertTrue(seen["hit"])
                self.assert_near(seen["to_eye"], scale(-1, d), 1e-7)
                self.assert_near(unit(sub(seen["position"], eye)), d, 1e-7)

    def test_fov_is_vertical(self):
        seen = self.explained("phantom:sphere", pixel=(0, 0), size="60x20", surface="iso=0.5",
                              camera="eye=0:-90:0,target=0:0:0,fov=40")
        camera = Camera((0, -90, 0), (0, 0, 0), (0, 0, 1), 60, 20, fov=40)
        self.assert_near(seen["to_eye"], scale(-1, camera.ray(0, 0)[1]), 1e-9)

    def test_orthographic_named_view_fits_the_bounding_sphere(self):
        one, other = (self.explained("phantom:sphere", pixel=(x, 10), size="20x20",
                                     surface="iso=0.25", camera="view=left,projection=orthographic")
                      for x in (9, 10))
        step = sub(other["position"], one["position"])  # left: image right is posterior, +y
        self.assert_near(step[1], 2 * self.BOUND / 20, 1e-6)
        self.assertEqual(one["to_eye"], other["to_eye"])

    def test_target_defaults_to_the_middle_and_up_to_superior(self):
        short, long = (self.exr("phantom:sphere", size="8x8", camera=c, surface="iso=0.5").channels
                       for c in ("eye=50:-60:20", "eye=50:-60:20,target=0:0:0,up=0:0:1"))
        self.assertEqual(short, long)


class SameSceneOtherwiseStored(TestCase):
    """The same body in the same place is the same picture, however its file lays it out."""

    CENTER = tuple((n - 1) / 2 for n in BLOB_DIMS)
    EYE, LIGHT = (30, -40, 25), (-20, -30, 40)

    def blob_exr(self, name, axes=(0, 1, 2), flipped=(), factor=1):
        """The blob with its axes stored in the order `axes`, those in `flipped` backwards, and
        every length times `factor`."""
        dims = [BLOB_DIMS[a] for a in axes]
        def value(*stored):
            index = [0, 0, 0]
            for place, axis in zip(stored, axes):
                index[axis] = BLOB_DIMS[axis] - 1 - place if axis in flipped else place
            return blob(*index)
        steps, origin = [], list(scale(-factor, self.CENTER))
        for axis in axes:
            step = [0, 0, 0]
            step[axis] = -factor if axis in flipped else factor
            origin[axis] = -origin[axis] if axis in flipped else origin[axis]
            steps.append(step)
        write_nrrd(self.folder / name, dims, grid(dims, value), directions=steps, origin=origin)
        return self.exr(name, size="48x48", surface="iso=0",
                        camera=f"eye={text(scale(factor, self.EYE))},target=0:0:0",
                        light=f"point,at={text(scale(factor, self.LIGHT))}")

    def assert_same_picture(self, one, other):
        # A ray that grazes the outline may fall either way.
        differ = sum(abs(a - b) > 1e-4 for a, b in zip(one.channels["R"], other.channels["R"]))
        self.assertLessEqual(differ, 2)
        self.assertGreater(len(one.hits()), 100)

    def test_permuted_axes(self):
        self.assert_same_picture(self.blob_exr("a.nrrd"), self.blob_exr("b.nrrd", axes=(2, 0, 1)))
        self.assert_same_picture(self.blob_exr("a.nrrd"), self.blob_exr("b.nrrd", axes=(1, 0, 2)))

    def test_mirrored_affine(self):
        for flipped in ((0,), (1, 2), (0, 1, 2)):
            self.assert_same_picture(self.blob_exr("a.nrrd"),
                                     self.blob_exr("b.nrrd", flipped=flipped))

    def test_rescaled_units(self):
        self.assert_same_picture(self.blob_exr("a.nrrd"), self.blob_exr("b.nrrd", factor=1000))
        self.assert_same_picture(self.blob_exr("a.nrrd"), self.blob_exr("b.nrrd", factor=0.001))


class Info(TestCase):
    def test_info_holds_the_contracts_keys(self):
        plane = SlantedPlane
        write_nrrd(self.folder / "plane.nrrd", plane.DIMS,
                   grid(plane.DIMS, lambda *index: round(dot(plane.SLOPE, index))),
                   directions=plane.STEPS, origin=plane.ORIGIN)
        told = json.loads(self.run_isolux("info", "plane.nrrd", "--json").stdout)
        self.assertEqual((told["kind"], told["type"]), ("volume", "i16"))
        self.assertEqual(told["dims"], list(plane.DIMS))
        self.assertEqual((told["min"], told["max"]), (-2 * 15, 3 * 19 + 5 * 11))
        self.assertEqual(told["bytes"], 2 * 20 * 16 * 12)
        self.assert_near(told["spacing"], [length(step) for step in plane.STEPS], 1e-9)
        self.assert_near(told["origin"], plane.ORIGIN, 1e-9)
        columns = [unit(step) for step in plane.STEPS]
        self.assert_near(told["direction"], [column[row] for row in range(3) for column in columns],
                         1e-9, 1e-12)
        self.assertTrue(all(told["min"] < iso < told["max"] for iso in told["suggested_iso"]))

    def test_built_in_volumes_lie_where_the_contract_says(self):
        for name, dims, spacing, origin in (("sphere", 65, 1, -32), ("sphere,size=33", 33, 2, -32),
                                            ("marschner-lobb", 41, 0.05, -1),
                                            ("head,size=52", 52, 5, -127.5)):
            told = json.loads(self.run_isolux("info", f"phantom:{name}", "--json").stdout)
            self.assertEqual(told["dims"], [dims] * 3)
            self.assert_near(told["spacing"], [spacing] * 3, 1e-12)
            self.assert_near(told["origin"], [origin] * 3, 1e-12)
        self.assertEqual((told["type"], told["units"]), ("i16", "HU"))  # the head, last

    def test_without_surfaces_a_volume_shows_the_first_of_its_suggested_iso_values(self):
        for name in ("phantom:marschner-lobb", "phantom:head,size=32"):
            told = json.loads(self.run_isolux("info", name, "--json").stdout)
            scene = {"size": "24x24", "camera": "view=left"}
            self.assertEqual(
                self.exr(name, **scene).channels,
                self.exr(name, surface=f"iso={told['suggested_iso'][0]!r}", **scene).channels)


if __name__ == "__main__":
    unittest.main()
