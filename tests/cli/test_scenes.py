"""What a picture carries, and that it can be made again; scene files; that no option is ignored;
that the number of threads does not matter (contract, 7 and 8)."""

import hashlib
import json
import re
import shlex
import subprocess
import unittest
from pathlib import Path
from unittest.mock import ANY

from isolux import PROGRAM, ROOT, SHARED, USAGE, WORK, TestCase, listed, needs_shared, options_of
from pictures import BLOB_DIMS, blob, grid, png_bytes, png_chunks, read_exr, read_png, write_nrrd

RICH = {"size": "40x32", "surface": ["iso=0,ka=0.1:0.2:0.3,kd=0.9:0.6:0.5,shininess=7", "iso=300"],
        "light": ["point,at=3:2:40,space=index,color=0.1:0.2:0.3",
                  "directional,to=-3:-5:8,attach=camera,intensity=0.7"],
        "ambient": "0.3:0.2:0.1", "camera": "eye=60:-50:40,target=8:7:6,fov=20",
        "display": "raw", "exposure": 0.8, "background": "0.1:0.2:0.3"}
# Shadows, a mirror and a translucent surface.
EFFECTS = {**RICH, "surface": ["iso=0,kr=0.5:0.4:0.3,opacity=0.6", "iso=300,kr=0.2:0.2:0.2"],
           "shadows": "on", "indirect": "path", "spp": 4}
DENOISED = {**EFFECTS, "denoise": "on"}
TRANSPORT = {**RICH, "shadows": "on", "indirect": "transport"}


class BlobCase(TestCase):
    """With the lopsided body of pictures.blob as blob.nrrd."""

    @classmethod
    def setUpClass(cls):
        cls.values = grid(BLOB_DIMS, blob)

    def setUp(self):
        super().setUp()
        write_nrrd(self.folder / "blob.nrrd", BLOB_DIMS, self.values,
                   directions=[(1, 0, 0), (0, 1, 0), (0, 0, 1)])

    def made(self, *inputs, name, **options):
        """The bytes of a picture."""
        return self.render(*inputs, name=name, **options).read_bytes()

    def texts(self, path):
        read = read_exr if str(path).endswith(".exr") else read_png
        return read(path).texts


class Provenance(BlobCase):
    def test_pictures_carry_version_scene_command_and_checksums(self):
        version = self.run_isolux("--version").stdout.split()[-1]
        checksum = hashlib.sha256((self.folder / "blob.nrrd").read_bytes()).hexdigest()
        for name in ("a.png", "a.exr"):
            texts = " ".join(self.texts(self.render("blob.nrrd", name=name, **RICH)).values())
            for part in (version, checksum, "blob.nrrd", "isolux render", "--exposure 0.8"):
                self.assertIn(part, texts, name)

    def test_every_file_of_a_detached_volume_has_its_checksum(self):
        write_nrrd(self.folder / "slices.nhdr", BLOB_DIMS, self.values,
                   data_file="slice.%02d 1 13 1", directions=[(1, 0, 0), (0, 1, 0), (0, 0, 1)])
        texts = " ".join(self.texts(self.render("slices.nhdr", name="a.png", size="8x8")).values())
        files = [self.folder / "slices.nhdr", *self.folder.glob("slice.??")]
        self.assertEqual(len(files), 14)
        for file in files:
            self.assertIn(hashlib.sha256(file.read_bytes()).hexdigest(), texts, file.name)

    def test_pictures_carry_no_output_path_time_or_thread_count(self):
        for ending in ("png", "exr"):
            wanted = self.made("blob.nrrd", name=f"a.{ending}", **RICH)
            (self.folder / "elsewhere").mkdir(exist_ok=True)
            for name, threads in ((f"elsewhere/hidden.{ending}", 1), (f"b.{ending}", 2),
                                  (f"c.{ending}", 7)):
                self.assertEqual(self.made("blob.nrrd", name=name, threads=threads, **RICH), wanted)

    def test_png_chunks_are_sound_and_hold_no_alpha(self):
        png = read_png(self.render("blob.nrrd", name="a.png", **RICH))  # checks every CRC
        kinds = [kind for kind, _ in png.chunks]
        self.assertEqual((kinds[0], kinds[-1]), (b"IHDR", b"IEND"))
        self.assertNotIn(b"tIME", kinds)
        self.assertEqual((png.width, png.height), (40, 32))

    def test_the_recorded_command_makes_the_same_bytes(self):
        for name in ("a.png", "a.exr"):
            path = self.render("blob.nrrd", name=name, **RICH)
            self.assert_command_remakes(path)

    def test_the_recorded_command_is_safe_for_a_shell(self):
        name = "it's a $(blob) & more.nrrd"
        (self.folder / "blob.nrrd").rename(self.folder / name)
        self.assert_command_remakes(self.render(name, name="a.png", size="24x24"))

    def assert_command_remakes(self, path):
        (command,) = (t for t in self.texts(path).values() if t.startswith("isolux render"))
        words = shlex.split(command)
        again = "again" + path.suffix
        self.run_isolux(*words[1:], "-o", again)
        self.assertEqual((self.folder / again).read_bytes(), path.read_bytes(), command)


class Again(BlobCase):
    def assert_remakes(self, path, *inputs, **how):
        name = "again" + path.suffix
        self.run_isolux("render", "--again", path, *inputs, "-o", name, **how)
        again = Path(how.get("cwd", self.folder)) / name
        self.assertEqual(again.read_bytes(), path.read_bytes())

    def test_the_same_bytes_from_files_and_phantoms(self):
        for ending in ("png", "exr"):
            self.assert_remakes(self.render("blob.nrrd", name=f"a.{ending}", **RICH))
            self.assert_remakes(self.render("phantom:sphere", name=f"b.{ending}", size="24x24"))
            self.assert_remakes(self.render(
                "phantom:marschner-lobb,size=21", "blob.nrrd", name=f"c.{ending}", size="24x24",
                surface=["iso=0.5", "iso=0,input=2"]))

    def test_raw_input_with_its_description(self):
        (self.folder / "voxels.raw").write_bytes(bytes(v % 251 for v in range(5 * 4 * 3)))
        self.assert_remakes(self.render("voxels.raw", name="a.png", size="16x16", dims="5x4x3",
                                        type="u8", spacing="1:2:3"))

    def test_a_png_from_an_exr_and_back(self):
        png, exr = (self.render("blob.nrrd", name=name, **RICH) for name in ("a.png", "a.exr"))
        for source, wanted in ((exr, png), (png, exr)):
            name = "again" + wanted.suffix
            self.run_isolux("render", "--again", source, "-o", name)
            self.assertEqual((self.folder / name).read_bytes(), wanted.read_bytes())

    def test_from_another_folder_with_the_input_named(self):
        for ending in ("png", "exr"):
            path = self.render("blob.nrrd", name=f"a.{ending}", **RICH)
            other = self.folder / "other"
            other.mkdir(exist_ok=True)
            self.assert_remakes(path, self.folder / "blob.nrrd", cwd=other)
            self.refused("render", "--again", path, "-o", f"b.{ending}", status=WORK, cwd=other,
                         about="blob.nrrd")

    def test_over_itself(self):
        path = self.render("blob.nrrd", name="a.png", **RICH)
        before = path.read_bytes()
        self.run_isolux("render", "--again", "a.png", "-o", "a.png")
        self.assertEqual(path.read_bytes(), before)

    def assert_refused(self, picture, *inputs, status=WORK, about=""):
        message = self.refused("render", "--again", picture, *inputs, "-o", "new.png",
                               status=status, about=about)
        self.assertFalse((self.folder / "new.png").exists(), message)

    def test_a_changed_input_is_refused(self):
        self.render("blob.nrrd", name="a.png", **RICH)
        data = bytearray((self.folder / "blob.nrrd").read_bytes())
        data[-1] ^= 1
        (self.folder / "blob.nrrd").write_bytes(data)
        self.assert_refused("a.png", about="blob.nrrd")

    def test_another_input_than_the_pictures_own_is_refused(self):
        self.render("blob.nrrd", name="a.png", **RICH)
        self.assert_refused("a.png", "phantom:sphere")
        self.render("phantom:sphere", name="b.png", size="16x16")
        self.assert_refused("b.png", "blob.nrrd")

    def test_another_phantom_than_the_pictures_own_is_refused(self):
        self.render("phantom:sphere", name="a.png", size="16x16")
        self.assert_refused("a.png", "phantom:sphere,size=9")

    def test_foreign_and_damaged_pictures_are_refused(self):
        path = self.render("blob.nrrd", name="a.png", **RICH)
        bare = [chunk for chunk in png_chunks(path.read_bytes()) if chunk[0] != b"iTXt"]
        (self.folder / "foreign.png").write_bytes(png_bytes(bare))
        self.assert_refused("foreign.png", about="foreign.png")
        self.assert_refused("missing.png", about="missing.png")
        self.assert_refused(".")
        (self.folder / "empty.png").write_bytes(b"")
        self.assert_refused("empty.png", about="empty.png")
        self.render("blob.nrrd", name="a.exr", **RICH)
        for name in ("a.png", "a.exr"):
            data = (self.folder / name).read_bytes()
            bad = "bad" + Path(name).suffix
            for size in (3, 9, 40, len(data) // 2, len(data) - 1):
                (self.folder / bad).write_bytes(data[:size])
                self.assert_refused(bad, about=bad)

    def test_an_edited_record_is_refused(self):
        path = self.render("blob.nrrd", name="a.png", **RICH)
        for old, new in ((b'"exposure":', b'"exposhur":'), (b'{"', b'{'),
                         (b'"isolux_scene":1', b'"isolux_scene":9'), (b'"sha256"', b'"sha512"')):
            chunks = [(kind, body.replace(old, new) if kind == b"iTXt" else body)
                      for kind, body in png_chunks(path.read_bytes())]
            (self.folder / "edited.png").write_bytes(png_bytes(chunks))
            done = self.run_isolux("render", "--again", "edited.png", "-o", "new.png",
                                   status=ANY)
            self.assertIn(done.returncode, (WORK, USAGE), new)
            self.assertRegex(done.stderr.splitlines()[-1], r"^isolux: error: edited.png.*: .*; ")

    @needs_shared
    def test_the_bad_png_files_of_the_shared_data_are_refused(self):
        paths = sorted((SHARED / "data/bad/png").iterdir())
        self.assertTrue(paths)
        for path in paths:
            self.assert_refused(path, about=path.name)


class SceneFiles(BlobCase):
    def scene(self, text, name="scene.json"):
        (self.folder / name).write_text(text if isinstance(text, str) else json.dumps(text))
        return name

    def test_a_saved_scene_makes_the_same_bytes(self):
        for ending in ("png", "exr"):
            wanted = self.made("blob.nrrd", name=f"a.{ending}", save_scene="a.json", **RICH)
            self.assertEqual(self.made(name=f"b.{ending}", scene="a.json"), wanted)

    def test_a_scene_can_be_saved_without_a_picture(self):
        self.run_isolux("render", "blob.nrrd", *listed(RICH), "--save-scene", "a.json")
        self.assertEqual(self.made(name="a.png", scene="a.json"),
                         self.made("blob.nrrd", name="b.png", **RICH))

    def test_a_scene_written_by_hand(self):
        self.scene({"isolux_scene": 1, "input": ["blob.nrrd"], "size": [40, 32],
                    "ambient": [1, 0.5, 0],
                    "surface": [{"iso": 0, "kd": [1, 0, 0]}, {"iso": 300, "shininess": 3}],
                    "light": [{"kind": "point", "at": [0, -30, 40]}], "camera": {"view": "left"}})
        self.assertEqual(
            self.png(scene="scene.json").rows,
            self.png("blob.nrrd", size="40x32", ambient="1:0.5:0", camera="view=left",
                     surface=["iso=0,kd=1:0:0", "iso=300,shininess=3"],
                     light="point,at=0:-30:40").rows)

    def test_the_command_line_goes_before_the_scene_file(self):
        self.render("blob.nrrd", name="a.png", save_scene="a.json", **RICH)
        for change in ({"exposure": 3}, {"size": "20x20"}, {"camera": "view=back"},
                       {"surface": "iso=200"}, {"light": "directional,to=0:0:1"}):
            self.assertEqual(self.made(name="b.png", scene="a.json", **change),
                             self.made("blob.nrrd", name="c.png", **{**RICH, **change}), change)
        self.assertEqual(self.made("phantom:sphere", name="b.png", scene="a.json"),
                         self.made("phantom:sphere", name="c.png", **RICH))

    def test_explain_takes_a_scene_file(self):
        self.run_isolux("render", "blob.nrrd", *listed(RICH), "--save-scene", "a.json")
        self.assertEqual(self.explained(pixel=(20, 16), scene="a.json"),
                         self.explained("blob.nrrd", pixel=(20, 16), **RICH))

    def assert_refused(self, text, status=USAGE, about="scene.json"):
        self.scene(text)
        self.refused("render", "blob.nrrd", "--scene", "scene.json", "-o", "a.png",
                     status=status, about=about)
        self.assertFalse((self.folder / "a.png").exists())

    def test_unknown_keys_are_refused_with_the_nearest_name(self):
        self.assert_refused({"isolux_scene": 1, "exposur": 2}, about="did you mean exposure")
        self.assert_refused({"isolux_scene": 1, "surface": [{"izo": 2}]}, about="did you mean iso")
        self.assert_refused({"isolux_scene": 1, "output": "a.png"}, about="output")
        self.assert_refused({"isolux_scene": 1, "threads": 1}, about="threads")

    def test_wrong_versions_bad_json_and_no_scenes_are_refused(self):
        for version in (0, 2, "1", None, [1]):
            self.assert_refused({"isolux_scene": version})
        for text in ("", "{", "[]", "1", "null", "{}", '{"isolux_scene": 1,}', "\x00\xff",
                     '{"isolux_scene": 1, "exposure": 1e999}', '{"isolux_scene": 1} trailing'):
            self.assert_refused(text)

    def test_wrong_types_and_ranges_are_refused(self):
        wrong = {
            "size": [None, 8, "8x8", [8], [8, 8, 8], [8.5, 8], [0, 8], ["8", 8], [1e30, 8],
                     [2 ** 70, 8]],
            "exposure": [None, "1", [1], -1, {}, True], "ambient": ["1:1:1", [1, 1], [1, 1, -1], 1],
            "background": [[0, 0, "0"]], "display": [1, "linear", ["raw"]],
            "camera": [[], "view=front", {"view": 1}, {"view": "up"}, {"fov": "30"},
                       {"eye": [0, 0]}],
            "surface": [{}, {"iso": 1}, [1], [{"iso": "1"}], [{}], [{"iso": 1, "ka": [2, 0, 0]}],
                        [{"iso": 1, "input": 1.5}], [{"iso": 1, "input": 7}],
                        [{"iso": 1, "kr": [1, 1, 2]}], [{"iso": 1, "opacity": 1.5}]],
            "light": [{}, [[]], [{"kind": "spot", "at": [1, 2, 3]}], [{"at": [1, 2, 3]}],
                      [{"kind": "point"}], [{"kind": "point", "at": "1:2:3"}]],
            "input": ["blob.nrrd", [1], {}, None], "shadows": ["dark", True], "indirect": ["dark", True],
            "spp": [4], "clip": [["at=0:0:0,normal=0:0:1"]], "transfer": ["ct-head"],
        }
        for key, values in wrong.items():
            for value in values:
                with self.subTest(f"{key}: {value}"):
                    self.scene({"isolux_scene": 1, key: value})
                    # An input named on the command line would go before the scene's.
                    inputs = [] if key == "input" else ["blob.nrrd"]
                    self.refused("render", *inputs, "--scene", "scene.json", "-o", "a.png",
                                 status=USAGE)

    def test_missing_scene_files_and_folders_are_refused(self):
        for name in ("missing.json", "."):
            message = self.refused("render", "--scene", name, "-o", "a.png", status=WORK)
            self.assertNotIn("fault of the program", message)


class NoSilentSwitch(BlobCase):
    """The contract's promise: each option of `render --help` and each field of its records either
    changes the picture or is refused."""

    # Every option or option.field: (what it is added to, the change). The input is the body.
    LIT = {"size": "24x24", "surface": "iso=0", "light": "point,at=30:-60:20",
           "camera": "eye=60:-50:40,target=8:7:6"}
    CHANGES = {
        "size": {"size": "24x25"},
        "surface": {"surface": ["iso=0", "iso=-500"]},
        "surface.iso": {"surface": "iso=200"},
        "surface.ka": {"surface": "iso=0,ka=0.1:0.1:0.2"},
        "surface.kd": {"surface": "iso=0,kd=0.8:0.8:0.7"},
        "surface.ks": {"surface": "iso=0,ks=0.3:0.9:0.3"},
        "surface.shininess": {"surface": "iso=0,shininess=3"},
        "surface.opacity": {"surface": "iso=0,opacity=0.5"},
        "shadows": {"light": "point,at=8:60:6", "shadows": "on"},
        "light": {"light": ["point,at=30:-60:20", "directional,to=0:0:1"]},
        "light.kind": {"light": "directional,to=30:-60:20"},
        "light.at": {"light": "point,at=30:-60:40"},
        "light.to": {"light": "directional,to=30:-60:21"},
        "light.color": {"light": "point,at=30:-60:20,color=1:1:0.5"},
        "light.intensity": {"light": "point,at=30:-60:20,intensity=0.5"},
        "light.attach": {"light": "point,at=30:-60:20,attach=camera"},
        "light.falloff": {"light": "point,at=30:-60:20,falloff=inverse-square"},
        "ambient": {"ambient": "0.5:1:1"},
        "indirect": {"indirect": "path"},
        "visibility": {"visibility": "raster"},
        "camera": {"camera": "eye=60:-50:41,target=8:7:6"},
        "camera.view": {"camera": "view=left"},
        "camera.eye": {"camera": "eye=60:-51:40,target=8:7:6"},
        "camera.target": {"camera": "eye=60:-50:40,target=8:7:5"},
        "camera.up": {"camera": "eye=60:-50:40,target=8:7:6,up=0:1:1"},
        "camera.projection": {"camera": "eye=60:-50:40,target=8:7:6,projection=orthographic"},
        "camera.fov": {"camera": "eye=60:-50:40,target=8:7:6,fov=31"},
        "display": {"display": "raw"},
        "exposure": {"exposure": 0.9},
        "background": {"background": "0:0:0.1"},
        "spacing": {"spacing": "1:1:1.5"},
    }
    # Fields that only mean something beside others: what they are compared with.
    BESIDE = {
        "surface.input": ({"surface": "iso=0.3"}, {"surface": "iso=0.3,input=2"}),
        "light.space": ({"light": "point,at=3:-9:6"}, {"light": "point,at=3:-9:6,space=index"}),
        "light.input": ({"light": "point,at=3:-9:6,space=index"},
                        {"light": "point,at=3:-9:6,space=index,input=2"}),
        "light.reference": ({"light": "point,at=30:-60:20,falloff=inverse-square,reference=40"},
                            {"light": "point,at=30:-60:20,falloff=inverse-square,reference=50"}),
        "surface.kr": ({"surface": "iso=0", "background": "0.5:0.5:0.5"},
                       {"surface": "iso=0,kr=0.5:0.5:0.5", "background": "0.5:0.5:0.5"}),
        "mirror-depth": (
            {"surface": "iso=0,kr=1:1:1", "background": "0.5:0.5:0.5", "mirror-depth": 0},
            {"surface": "iso=0,kr=1:1:1", "background": "0.5:0.5:0.5", "mirror-depth": 1}),
        "bounces": ({"indirect": "path", "bounces": 1}, {"indirect": "path", "bounces": 3}),
        "spp": ({"indirect": "path", "spp": 4}, {"indirect": "path", "spp": 5}),
        "error": ({"indirect": "path", "error": 0.5}, {"indirect": "path", "error": 0.01}),
        "indirect-memory": ({"indirect": "transport"},
                            {"indirect": "transport", "indirect-memory": "60k"}),
        "seed": ({"indirect": "path", "seed": 1}, {"indirect": "path", "seed": 2}),
        "denoise": ({"indirect": "path", "spp": 4},
                    {"indirect": "path", "spp": 4, "denoise": "on"}),
        "camera.height": (
            {"camera": "eye=60:-50:40,target=8:7:6,projection=orthographic,height=20"},
            {"camera": "eye=60:-50:40,target=8:7:6,projection=orthographic,height=21"}),
        "dims": ({"dims": "4x3x5", "type": "u8", "surface": "iso=40"},
                 {"dims": "3x4x5", "type": "u8", "surface": "iso=40"}),
        "type": ({"dims": "5x3x2", "type": "i16", "surface": "iso=9000"},
                 {"dims": "5x3x2", "type": "i16be", "surface": "iso=9000"}),
    }
    REFUSED = {
        "transfer": {"transfer": "ct-head"}, "clip": {"clip": "at=0:0:0,normal=0:0:1"},
        # This input has one volume, is no DICOM and no mesh; test_formats.py and test_mesh.py have
        # those that do.
        "volume": {"volume": 1}, "series": {"series": 1}, "crease": {"crease": 30},
    }
    # Not of the scene: tested where they belong.
    OTHER = {"output", "scene", "save-scene", "again", "threads", "isa", "progress",
             "max-memory", "trust"}

    def test_every_option_and_field_is_listed_here(self):
        names = set()
        for option, fields in options_of("render").items():
            names |= {option} | {f"{option}.{field}" for field in fields}
        listed_here = [*self.CHANGES, *self.BESIDE, *self.REFUSED, *self.OTHER]
        self.assertEqual(len(listed_here), len(set(listed_here)), "something is listed twice")
        self.assertEqual(set(listed_here), names)

    def pixels(self, inputs, options):
        return self.png(*inputs, **{**self.LIT, **options}).rows

    def test_each_changes_the_picture(self):
        plain = self.pixels(["blob.nrrd"], {})
        self.assertGreater(len(set(map(bytes, plain))), 5)
        for name, change in self.CHANGES.items():
            self.assertTrue(self.pixels(["blob.nrrd"], change) != plain, name)

    def test_each_that_needs_others_changes_the_picture_beside_them(self):
        write_nrrd(self.folder / "moved.nrrd", BLOB_DIMS, self.values, origin=(4, 2, -3),
                   directions=[(1, 0, 0), (0, 1.2, 0), (0, 0, 1)])
        (self.folder / "voxels.raw").write_bytes(bytes(n * n % 97 for n in range(60)))
        for name, (one, other) in self.BESIDE.items():
            raw = name in ("dims", "type")
            inputs = ["voxels.raw"] if raw else ["moved.nrrd", "blob.nrrd"]
            common = {"camera": "view=left"} if raw else {}
            self.assertTrue(self.pixels(inputs, {**common, **one}) !=
                            self.pixels(inputs, {**common, **other}), name)

    def test_each_of_a_later_version_is_refused(self):
        for name, change in self.REFUSED.items():
            self.refused("render", "blob.nrrd", "-o", "a.png", *listed({**self.LIT, **change}),
                         status=USAGE, about=name.split(".")[-1])

    def test_spacing_is_honoured_or_refused_for_built_in_volumes(self):
        for phantom in ("phantom:sphere", "phantom:marschner-lobb", "phantom:head,size=32"):
            words = ["render", phantom, "--size", "24x24", "--camera", "view=left", "-o", "a.png"]
            self.run_isolux(*words)
            plain = read_png(self.folder / "a.png").rows
            done = self.run_isolux(*words, "--spacing", "1:1:3", status=ANY)
            changed = read_png(self.folder / "a.png").rows != plain
            self.assertTrue(done.returncode == USAGE or changed, phantom)

    def test_explain_takes_the_options_of_render(self):
        render, explain = options_of("render"), options_of("explain")
        own = {"output", "save-scene", "again"}
        self.assertEqual(render.keys() - explain.keys(), own)
        self.assertEqual(explain.keys() - render.keys(), {"pixel", "json"})
        for option in render.keys() - own:
            self.assertEqual(render[option], explain[option])


class SameBytes(BlobCase):
    def test_any_number_of_threads_makes_the_same_bytes(self):
        scenes = [(["blob.nrrd"], RICH), (["blob.nrrd"], EFFECTS), (["blob.nrrd"], TRANSPORT),
                  (["blob.nrrd"], DENOISED),
                  (["phantom:marschner-lobb"], {"size": "64x64"}),
                  (["phantom:head,size=48"], {"size": "50x70", "surface": ["iso=-300", "iso=300"]})]
        for inputs, options in scenes:
            for ending in ("png", "exr"):
                one, two, seven = (self.made(*inputs, name=f"a.{ending}", threads=n, **options)
                                   for n in (1, 2, 7))
                self.assertEqual(one, two, inputs)
                self.assertEqual(one, seven, inputs)

    def test_avx2_and_avx512_make_the_same_bytes(self):
        lamp = {"light": ["point,at=40:-300:200,falloff=inverse-square,reference=300",
                          "directional,to=1:-1:0.5,color=1:0.5:0.2"]}
        scenes = [(["blob.nrrd"], RICH), (["blob.nrrd"], EFFECTS), (["blob.nrrd"], TRANSPORT),
                  (["blob.nrrd"], DENOISED),
                  (["phantom:marschner-lobb"], {"size": "65x63"}),
                  (["phantom:sphere"], {"size": "64x64", "camera":
                                        "view=top,projection=orthographic", **lamp}),
                  (["phantom:head,size=64"], {"size": "150x170", "surface":
                                              ["iso=-300,shininess=200", "iso=300"], **lamp})]
        for name in ("avx2", "avx512"):
            words = ["render", "phantom:sphere", "--size", "8x8", "-o", "a.png", "--isa", name]
            done = subprocess.run([PROGRAM, *words], cwd=self.folder, capture_output=True,
                                  text=True)
            if done.returncode:
                self.assertIn("this machine does not have it", done.stderr)
                self.skipTest(f"this machine has no {name}")
        for inputs, options in scenes:
            for ending in ("png", "exr"):
                best, avx2, avx512 = (
                    self.made(*inputs, name=f"a.{ending}", **isa, **options)
                    for isa in ({}, {"isa": "avx2"}, {"isa": "avx512"}))
                self.assertEqual(avx2, avx512, (inputs, ending))
                self.assertEqual(best, avx512, (inputs, ending))

    def test_the_plain_code_and_sse4_draw_the_same_picture_within_rounding(self):
        options = {"size": "64x64", "surface": ["iso=-300", "iso=300"]}
        best = self.exr("phantom:head,size=48", **options)
        for name in ("scalar", "sse4"):
            other = self.exr("phantom:head,size=48", isa=name, **options)
            for y in range(64):
                for x in range(64):
                    self.assertEqual(other.at("surface.id", x, y), best.at("surface.id", x, y))
                    self.assert_near(other.triple("", x, y), best.triple("", x, y), 1e-4, 1e-4)


    def test_progress_shows_only_when_asked_for_and_changes_nothing(self):
        words = ["render", "blob.nrrd", *listed(RICH), "-o"]
        quiet = self.run_isolux(*words, "a.png")
        told = self.run_isolux(*words, "b.png", "--progress")
        self.assertEqual((quiet.stdout, told.stdout), ("", ""))
        self.assertNotIn("%", quiet.stderr)
        self.assertIn("%", told.stderr)
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())


class Manual(TestCase):
    PAGE = ROOT / "docs/manual.md"

    @unittest.skipUnless(PAGE.is_file(), f"{PAGE} is not here")
    def test_the_manual_page_is_what_the_program_prints(self):
        self.assertEqual(self.run_isolux("manual").stdout, self.PAGE.read_text())

    def test_the_manual_lists_every_option_of_every_command(self):
        manual = self.run_isolux("manual").stdout
        for command in ("render", "explain", "info", "bench"):
            for option, fields in options_of(command).items():
                self.assertRegex(manual, rf"--{re.escape(option)}\b")
                for field in fields:
                    head = "point\\|directional" if field == "kind" else f"`{field}="
                    self.assertIn(head, manual)


if __name__ == "__main__":
    unittest.main()
