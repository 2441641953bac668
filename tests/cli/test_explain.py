"""`isolux explain`: its printed sums are worked out again, and held against the pictures."""

import math
import re
import unittest

from closed_form import dot
from isolux import TestCase, listed
from pictures import BLOB_DIMS, blob, grid, write_nrrd
from printed_sums import as_tuple, evaluate, steps_of

# name: inputs, options
SCENES = {
    "the headlight alone": (["phantom:sphere"], {"size": "64x64"}),
    "lamps of every kind": (["blob.nrrd"], {
        "size": "48x64",
        "surface": "iso=0,ka=0.2:0.1:0.05,kd=0.9:0.6:0.3,ks=0.3:0.5:0.7,shininess=12",
        "light": ["point,at=30:-60:20,color=1:0.5:0.2,falloff=inverse-square,reference=55",
                  "point,at=3:2:40,space=index,color=0.1:0.2:0.3",
                  "directional,to=0.1:1:0.2,color=0:1:0", "directional,to=-3:-5:8,intensity=0.25",
                  "point,at=5:7:-3,attach=camera,color=0.3:0.2:0.1",
                  "directional,to=1:1:1,attach=camera,intensity=0.1"],
        "camera": "eye=60:-50:40,target=8:7:6,fov=20"}),
    "raw display, exposed": (["phantom:marschner-lobb"], {
        "size": "64x48", "surface": "iso=0.5,shininess=3", "display": "raw", "exposure": 0.37,
        "light": "point,at=1:-2:3,color=1:0.9:0.1", "ambient": "0.3:0.2:0.1"}),
    "an edge-on lamp and a tight highlight": (["phantom:sphere"], {
        "size": "64x64", "surface": "iso=0.5,shininess=1000,ks=1:1:1",
        "light": ["directional,to=1:0:0", "directional,to=0:-1:0", "directional,to=0:0:-1"],
        "camera": "view=front,projection=orthographic,height=36", "exposure": 0.5}),
    "no exponent, two surfaces, a background": (["phantom:sphere,size=33"], {
        "size": "64x64", "surface": ["iso=0.9", "iso=0.3,shininess=0,kd=1:0.5:0.25"],
        "light": "point,at=-40:-90:10,falloff=inverse-square", "background": "0.2:0.4:1.5",
        "exposure": 0.004, "camera": "view=left"}),
    "a broken exponent": (["phantom:sphere"], {
        "size": "40x40", "surface": "iso=0.5,shininess=7.25",
        "light": "directional,to=0.5:-1:0.5"}),
}
EFFECTS = {
    "layers, a mirror and shadows": (["phantom:sphere,size=33"], {
        "size": "64x64", "surface": ["iso=0.9,kr=0.3:0.2:0.1", "iso=0.3,opacity=0.375"],
        "light": ["point,at=-40:-90:10,falloff=inverse-square,reference=90",
                  "directional,to=1:1:0.2"],
        "shadows": "on", "background": "0.2:0.4:0.6", "camera": "view=left"}),
    "indirect light": (["blob.nrrd"], {
        "size": "48x64", "surface": ["iso=300,kd=0.5:0.6:0.7", "iso=0,opacity=0.5"],
        "light": "point,at=30:-60:20", "ambient": "0.1:0.2:0.3", "shadows": "on",
        "indirect": "path", "bounces": 3, "spp": 8,
        "camera": "eye=60:-50:40,target=8:7:6,fov=20"}),
    "denoised indirect light": (["blob.nrrd"], {
        "size": "48x64", "surface": ["iso=300,kd=0.5:0.6:0.7", "iso=0,opacity=0.5"],
        "light": "point,at=30:-60:20", "ambient": "0.1:0.2:0.3", "shadows": "on",
        "indirect": "path", "bounces": 3, "spp": 2, "denoise": "on",
        "camera": "eye=60:-50:40,target=8:7:6,fov=20"}),
}
# Printed without numbers to work out.
GIVEN = {"V", "E", "E1", "E2", "E3", "background as far as it is seen",
         "mirror: kr times what the mirrored rays bring", "o", "d", "t", "n", "e", "Ia", "specular"}  # printed without numbers to work out


class Explain(TestCase):
    @classmethod
    def setUpClass(cls):
        cls.values = grid(BLOB_DIMS, blob)

    def setUp(self):
        super().setUp()
        write_nrrd(self.folder / "blob.nrrd", BLOB_DIMS, self.values, "f32",
                   directions=[(1, 0, 0), (0, 1, 0), (0, 0, 1)])

    def text(self, inputs, options, pixel):
        return self.run_isolux("explain", *inputs, "--pixel", "%d,%d" % pixel,
                               *listed(options)).stdout

    def each_scene(self, step, scenes=SCENES):
        """Inputs, options, and pixels spread over the picture: hits and misses."""
        for inputs, options in scenes.values():
            width, height = map(int, options["size"].split("x"))
            yield inputs, options, [(x, y) for x in range(step // 3, width, step)
                                    for y in range(step // 3, height, step)]

    def test_every_printed_step_holds_within_its_printed_digits(self):
        for inputs, options, pixels in self.each_scene(9, SCENES | EFFECTS):
            worked_out = 0
            for pixel in pixels:
                text = self.text(inputs, options, pixel)
                for step in steps_of(text):
                    if step.numbers is None:
                        self.assertIn(step.name, GIVEN, text)
                        continue
                    worked_out += 1
                    numbers = as_tuple(evaluate(step.numbers))
                    for again, result in zip(numbers, step.result, strict=True):
                        self.assertLessEqual(
                            abs(again.value - result.value),
                            again.error + result.error + 1e-12 * abs(again.value),
                            f"pixel {pixel}: {step.name}: {step.numbers} is not {result.value}")
                    if step.byte is not None:
                        self.assertLessEqual(abs(step.byte - step.result[0].value), 0.5 + 1e-6)
            self.assertGreater(worked_out, 75)  # three hits have as many

    def test_every_step_of_the_model_is_printed(self):
        _, options = SCENES["lamps of every kind"]
        text = self.text(["blob.nrrd"], options, (24, 32))
        names = [step.name for step in steps_of(text)]
        for name in ("o", "d", "t", "p", "n", "e", "Ia", "ambient R", "I B", "shown G"):
            self.assertEqual(names.count(name), 1, name)
        lamps = options["light"]
        for name in ("l", "cos θ", "θ", "r", "cos φ", "φ", "diffuse R", "diffuse G", "diffuse B"):
            self.assertEqual(names.count(name), len(lamps), name)
        self.assertEqual(names.count("P - p"), sum(lamp.startswith("point") for lamp in lamps))
        self.assertEqual(names.count("falloff"), 1)
        self.assertEqual(names.count("specular") + names.count("specular R"), len(lamps))
        self.assertGreater(names.count("specular"), 0)  # a lamp is behind

    def test_the_vectors_are_unit_ones_and_e_is_minus_d(self):
        for inputs, options, pixels in self.each_scene(step=30):
            for pixel in pixels:
                vectors = {step.name: [n.value for n in step.result]
                           for step in steps_of(self.text(inputs, options, pixel))}
                for name in {"d", "n", "e", "l", "r"} & vectors.keys():
                    self.assert_near(dot(vectors[name], vectors[name]), 1, 1e-6, 0, name)
                if "e" in vectors:
                    self.assertEqual(vectors["e"], [-c for c in vectors["d"]])

    def test_text_and_json_agree(self):
        for inputs, options, pixels in self.each_scene(step=30):
            for pixel in pixels:
                printed = {}
                for step in steps_of(self.text(inputs, options, pixel)):
                    printed.setdefault(step.name, []).append(step.result)
                seen = self.explained(*inputs, pixel=pixel, **options)
                wanted = {f"shown {c}": [] for c in "RGB"}  # that is held against the PNG below
                if seen["hit"]:
                    wanted |= {"p": [seen["position"]], "n": [seen["normal"]],
                               "e": [seen["to_eye"]]}
                    for n, c in enumerate("RGB"):
                        wanted[f"ambient {c}"] = [[seen["ambient"][n]]]
                        wanted[f"I {c}"] = [[seen["total"][n]]]
                        wanted[f"diffuse {c}"] = [[lamp["diffuse"][n]] for lamp in seen["lights"]]
                        wanted[f"specular {c}"] = [[lamp["specular"][n]] for lamp in seen["lights"]
                                                   if lamp["cos_theta"] > 0]
                    for name, key in (("l", "to_light"), ("r", "reflected"), ("cos θ", "cos_theta"),
                                      ("cos φ", "cos_phi")):
                        wanted[name] = [as_list(lamp[key]) for lamp in seen["lights"]]
                for name, rows in wanted.items():
                    for row, results in zip(rows, printed.get(name, []) if rows else [],
                                            strict=True):
                        for value, result in zip(row, results, strict=True):
                            self.assertLessEqual(abs(value - result.value), 1.01 * result.error,
                                                 name)

    def test_json_holds_the_contracts_keys_and_adds_up(self):
        for inputs, options, pixels in self.each_scene(step=15):
            for pixel in pixels:
                seen = self.explained(*inputs, pixel=pixel, **options)
                self.assertLessEqual({"hit", "surface", "position", "normal", "to_eye", "ambient",
                                      "lights", "indirect", "mirror", "total"}, seen.keys())
                for lamp in seen["lights"]:
                    self.assertLessEqual({"to_light", "reflected", "cos_theta", "cos_phi",
                                          "visibility", "diffuse", "specular"}, lamp.keys())
                    self.assertEqual(lamp["visibility"], 1)
                    self.assert_near(dot(seen["normal"], lamp["to_light"]), lamp["cos_theta"],
                                     1e-12, 1e-15)
                    self.assert_near(dot(lamp["reflected"], seen["to_eye"]), lamp["cos_phi"],
                                     1e-12, 1e-15)
                if not seen["hit"]:
                    self.assertEqual(seen["surface"], -1)
                    continue
                terms = [seen["ambient"], seen["indirect"], seen["mirror"]]
                terms += [lamp[key] for lamp in seen["lights"] for key in ("diffuse", "specular")]
                self.assert_near(seen["total"], [sum(c) for c in zip(*terms)], 1e-14, 1e-15)

    def test_layers_shadows_mirrors_and_indirect_light_add_up_to_the_picture(self):
        for inputs, options, pixels in self.each_scene(7, EFFECTS):
            exr = self.exr(*inputs, **options)
            most_layers, shares = 0, set()
            for x, y in pixels:
                seen = self.explained(*inputs, pixel=(x, y), **options)
                self.assertEqual(seen["hit"], bool(seen["layers"]))
                most_layers = max(most_layers, len(seen["layers"]))
                terms = [seen["ambient"], seen["indirect"], seen["mirror"], seen["background"]]
                terms += [lamp[key] for lamp in seen["lights"] for key in ("diffuse", "specular")]
                self.assert_near(seen["total"], [sum(c) for c in zip(*terms)], 1e-12, 1e-12)
                weighted = [[layer["weight"] * c for c in layer["total"]]
                            for layer in seen["layers"]]
                weighted += [seen["mirror"], seen["background"]]
                self.assert_near(seen["total"], [sum(c) for c in zip(*weighted)], 1e-12, 1e-12)
                for layer in seen["layers"]:
                    shares |= {round(lamp["visibility"], 6) for lamp in layer["lights"]}
                for name in ("indirect", "mirror"):
                    self.assert_near(exr.triple(name, x, y), seen[name], 3e-6, 3e-6, name)
                self.assert_near(exr.triple("", x, y), seen["total"], 3e-6, 3e-6)
            self.assertGreater(most_layers, 1)
            self.assertGreater(len(shares), 1)  # lit, and in shadow or dimmed

    def test_the_places_of_the_first_bounce_are_told_in_text_and_json_by_their_shares(self):
        inputs, options = EFFECTS["indirect light"]
        named = 0
        for pixel in [(x, y) for x in range(4, 48, 8) for y in range(4, 64, 8)]:
            seen = self.explained(*inputs, pixel=pixel, **options)
            self.assertEqual("first_bounce" in seen, seen["hit"])
            if not seen["hit"]:
                continue
            first = seen["first_bounce"]
            shares = [sender["share"] for sender in first["senders"]]
            self.assertEqual(shares, sorted(shares, reverse=True))
            self.assertLessEqual(len(shares), 8)
            self.assertLessEqual(sum(shares) + first["sky"], 1 + 1e-9)
            told = re.findall(r"^    ([\d.]+) % from surface (\d+) at \((.*)\), ",
                              self.text(inputs, options, pixel), re.M)
            self.assertEqual([(f"{round(1000 * s['share']) / 10:g}", str(s["surface"]),
                               [f"{c:.9g}" for c in s["position"]]) for s in first["senders"]],
                             [(share, surface, [f"{float(c):.9g}" for c in at.split(", ")])
                              for share, surface, at in told])
            named += len(shares)
        self.assertGreater(named, 20)

    def test_json_has_at_least_nine_significant_digits(self):
        seen = self.explained("phantom:sphere", pixel=(30, 25), size="64x64")
        for number in (*seen["position"], *seen["normal"][:2], seen["lights"][0]["cos_phi"]):
            self.assertGreaterEqual(len(repr(number).lstrip("-0.").replace(".", "")), 9, number)

    def test_json_equals_the_layers_of_the_exr_but_for_the_rounding_of_floats(self):
        half_step = 2.0 ** -24  # of a 32-bit float, as a share
        for inputs, options, pixels in self.each_scene(step=15):
            exr = self.exr(*inputs, **options)
            for x, y in pixels:
                seen = self.explained(*inputs, pixel=(x, y), **options)
                self.assertEqual(seen["surface"], exr.at("surface.id", x, y))
                wanted = {"": seen["total"], "ambient": seen["ambient"],
                          "normal": seen["normal"], "position": seen["position"]}
                for term in ("diffuse", "specular"):
                    wanted[term] = [sum(lamp[term][c] for lamp in seen["lights"]) for c in range(3)]
                for layer, triple in wanted.items():
                    # Pictures are lit in floats, by some twenty operations a term.
                    is_lit = layer in ("", "diffuse", "specular")
                    relative, absolute = (3e-6, 3e-6) if is_lit else (1.01 * half_step, 1e-30)
                    self.assert_near(exr.triple(layer, x, y), triple, relative, absolute, layer)
                if seen["hit"]:
                    self.assert_near(exr.at("depth.Z", x, y), seen["depth"], 1.01 * half_step, 0)

    def test_the_last_lines_are_the_pixel_of_the_png(self):
        for inputs, options, pixels in self.each_scene(step=9):
            png = self.png(*inputs, **options)
            for pixel in pixels:
                *_, r, g, b = steps_of(self.text(inputs, options, pixel))
                self.assertEqual([r.name, g.name, b.name], ["shown R", "shown G", "shown B"])
                self.assertEqual((r.byte, g.byte, b.byte), png.at(*pixel), pixel)

    def test_the_radiance_that_display_begins_with_is_that_of_the_exr(self):
        for inputs, options, pixels in self.each_scene(step=15):
            exr = self.exr(*inputs, **options)
            for pixel in pixels:
                last = steps_of(self.text(inputs, options, pixel))[-3:]
                shown = [float(re.search(r"\* ([^*()]+)\)", step.numbers[5:])[1]) for step in last]
                self.assertEqual(shown, [float(f"{c:.9g}") for c in exr.triple("", *pixel)])

    def test_a_miss_shows_the_background_and_is_no_error(self):
        options = {"size": "16x16", "background": "0.1:2:0.3"}
        self.assertIn("background", self.text(["phantom:sphere"], options, (0, 0)))
        seen = self.explained("phantom:sphere", pixel=(0, 0), **options)
        self.assertEqual((seen["hit"], seen["total"], seen["lights"]), (False, [0.1, 2, 0.3], []))

    def test_a_lamp_in_the_surface_itself_adds_nothing_and_no_nan(self):
        options = {"size": "1x1", "surface": "iso=0.5",
                   "camera": "view=front,projection=orthographic,height=20"}
        x, y, z = self.explained("phantom:sphere", pixel=(0, 0), **options)["position"]
        options["light"] = f"point,at={x!r}:{y!r}:{z!r},falloff=inverse-square"
        seen = self.explained("phantom:sphere", pixel=(0, 0), **options)
        self.assertTrue(all(map(math.isfinite, seen["total"])))
        self.assertNotRegex(self.text(["phantom:sphere"], options, (0, 0)), "nan|inf")
        exr = self.exr("phantom:sphere", **options)
        self.assertTrue(all(map(math.isfinite, exr.channels["R"])))


def as_list(value):
    return value if isinstance(value, list) else [value]


if __name__ == "__main__":
    unittest.main()
