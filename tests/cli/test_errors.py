"""What cannot be done, and what is asked wrongly: one clear last line, the right exit status,
nothing on standard output, no partial file, and what was there before survives (contract, 7)."""

import gzip
import io
import math
import plistlib
import resource
import shutil
import subprocess
import tarfile
import unittest

from isolux import PROGRAM, SHARED, USAGE, WORK, TestCase, needs_shared, without_sanitizers
from pictures import read_exr, voxel_bytes, write_nrrd

HEADER = "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 4 4\nendian: little\nencoding: raw\n"
LIMIT = 1 << 30  # bytes of address space


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


def runs_in_limited_memory():
    """A build with a sanitizer does not: it reserves terabytes."""
    return subprocess.run([PROGRAM, "--version"], capture_output=True,
                          preexec_fn=limit_memory).returncode == 0


class Refusals(TestCase):
    """Every refusal is tried over an existing picture, in a folder that must stay as it is."""

    def contents(self):
        return {p: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}

    def render_refused(self, *words, status, about="", output="old.png", **how):
        (self.folder / "old.png").write_bytes(b"an older picture")
        before = self.contents()
        message = self.refused("render", *words, "-o", output, status=status, about=about, **how)
        self.assertEqual(self.contents(), before, message)
        return message

    def sphere_refused(self, *words, **how):
        return self.render_refused("phantom:sphere,size=9", "--size", "8x8", *words, **how)


class WrongCommands(Refusals):
    def usage(self, *words, about):
        with self.subTest(words):
            self.sphere_refused(*words, status=USAGE, about=about)

    def test_unknown_commands(self):
        self.refused("rendr", status=USAGE, about="rendr")
        self.refused("--size", "8x8", status=USAGE, about="--size")

    def test_unknown_options_are_refused_with_the_nearest_name(self):
        self.usage("--exposur", "3", about="did you mean --exposure?")
        self.usage("--exposur=3", about="did you mean --exposure?")
        self.usage("--ligth", "directional,to=0:0:1", about="did you mean --light?")
        self.usage("--zzzzzz", "3", about="--zzzzzz")
        self.usage("-x", about="-x")
        self.refused("info", "phantom:sphere", "--size", "8x8", status=USAGE, about="--size")
        self.refused("manual", "more", status=USAGE, about="more")
        self.refused("info", "phantom:sphere", "phantom:head", status=USAGE)

    def test_unknown_fields_are_refused_with_the_nearest_name(self):
        self.usage("--surface", "izo=1", about="did you mean iso")
        self.usage("--surface", "iso=1,zzzzzz=2", about="zzzzzz")
        self.usage("--light", "point,att=1:2:3", about="did you mean at")
        self.usage("--camera", "veiw=front", about="did you mean view")
        self.usage("--camera", "front", about="front")
        self.usage("--light", "spot,at=0:0:9", about="spot")

    def test_wrong_types_and_numbers_out_of_range(self):
        wrong = {
            "--size": ["8", "8x", "x8", "8x8x8", "1.5x3", "axb", "0x8", "8x-1", "1e9x1",
                       "99999x8", ""],
            "--exposure": ["x", "-1", "nan", "inf", "1,5", "1e999", "", "0x10"],
            "--ambient": ["1", "1:2", "1:2:3:4", "a:b:c", "1,2,3", "-1:0:0", "nan:0:0", "1:2:"],
            "--background": ["-1:0:0", "white", "inf:0:0"],
            "--display": ["linear", "SRGB", ""],
            "--threads": ["0", "-1", "x", "1.5", "99999"],
            "--camera": ["view=up", "fov=0", "fov=180", "fov=x", "projection=fisheye", "view=",
                         "eye=1:2", "projection=orthographic,height=0", "eye=1:1:1,up=0:0:0",
                         "eye=1:1:1,target=1:1:1", "eye=0:0:9,target=0:0:0,up=0:0:2", ""],
            "--surface": ["iso=x", "iso=nan", "iso=", "iso", "iso=1,ka=2:0:0", "iso=1,kd=-0.1:0:0",
                          "iso=1,ks=0:0:1.5", "iso=1,ka=1", "iso=1,shininess=-1", "iso=1,input=0",
                          "iso=1,input=2", "iso=1,input=1.5", "iso=1,,ka=0:0:0", "iso=1,iso=2",
                          "ka=1:1:1", ""],
            "--light": ["point", "directional", "at=1:2:3", "point,at=1:2", "point,at=1:2:x", "",
                        "directional,to=0:0:0", "point,to=1:2:3", "directional,at=1:2:3",
                        "point,at=1:2:3,color=-1:0:0", "point,at=1:2:3,intensity=-1",
                        "point,at=1:2:3,falloff=linear", "point,at=1:2:3,at=4:5:6",
                        "point,at=1:2:3,falloff=inverse-square,reference=0",
                        "point,at=1:2:3,space=index,input=3"],
        }
        for option, values in wrong.items():
            for value in values:
                self.usage(f"{option}={value}" if option == "--threads" else option,
                           *([] if option == "--threads" else [value]), about=option)

    def test_fields_that_exclude_or_need_each_other(self):
        for light in ("directional,to=1:0:0,falloff=inverse-square",
                      "directional,to=1:0:0,falloff=inverse-square,reference=9",
                      "point,at=1:2:3,reference=9", "point,at=1:2:3,input=1",
                      "point,at=1:2:3,space=index,attach=camera"):
            self.usage("--light", light, about="--light")
        for camera in ("view=front,eye=1:2:3", "view=front,target=1:2:3", "view=front,up=0:0:1",
                       "target=1:2:3", "up=0:0:1", "height=9",
                       "view=front,projection=orthographic,fov=30"):
            self.usage("--camera", camera, about="--camera")

    def test_options_that_need_a_raw_file(self):
        self.usage("--dims", "3x3x3", about="--dims")
        self.usage("--type", "u8", about="--type")
        (self.folder / "voxels.raw").write_bytes(bytes(27))
        self.render_refused("voxels.raw", "--dims", "3x3x3", status=USAGE, about="--type")
        self.render_refused("voxels.raw", "--type", "u8", status=USAGE, about="--dims")
        for dims in ("3x3", "0x3x3", "3x3x-3", "3x3x3x3"):
            self.render_refused("voxels.raw", "--dims", dims, "--type", "u8", status=USAGE,
                                about="--dims")
        for spacing in ("0:1:1", "-1:1:1", "nan:1:1", "1:1"):
            self.render_refused("voxels.raw", "--dims", "3x3x3", "--type", "u8",
                                "--spacing", spacing, status=USAGE, about="--spacing")

    def test_a_value_is_missing(self):
        self.refused("render", "phantom:sphere", "-o", "a.png", "--size", status=USAGE,
                     about="--size")
        self.refused("render", "phantom:sphere", "-o", status=USAGE, about="--output")

    def test_an_option_is_no_value_of_the_option_before_it(self):
        self.usage("--exposure", about="--exposure")  # "-o" follows

    def test_an_option_that_counts_once_is_given_twice(self):
        for words in (["--exposure", "1"], ["--camera", "view=front"], ["--ambient", "1:1:1"],
                      ["--threads", "1"], ["--display", "raw"], ["--scene", "a.json"]):
            self.usage(*words, *words, about=words[0])
        self.usage("-o", "other.png", about="--output")

    def test_what_later_versions_will_do_is_refused_not_ignored(self):
        for words in (["--indirect-memory", "500M"],
                      ["--transfer", "ct-head"], ["--clip", "at=0:0:0,normal=0:0:1"],
                      ["--bounces", "2"], ["--error", "0.1"],
                      ["--spp", "16"], ["--seed", "1"], ["--denoise", "on"]):
            self.usage(*words, about=words[0])

    def test_indirect_light_that_does_not_fit_its_memory_is_refused(self):
        message = self.refused("render", "phantom:sphere", "--size", "32x32", "--indirect",
                               "transport", "--indirect-memory", "20k", "-o", "old.png",
                               status=WORK, about="--indirect-memory")
        self.assertIn("take", message)

    def test_an_unknown_instruction_set_is_refused(self):
        self.usage("--isa", "neon", about="--isa")

    def test_what_later_versions_will_do_may_be_said_to_be_off(self):
        self.render("phantom:sphere,size=9", size="8x8", indirect="off", denoise="off")

    def test_an_output_must_be_named_and_be_png_or_exr(self):
        self.refused("render", "phantom:sphere", status=USAGE, about="--output")
        for name in ("a.jpg", "a", "a.png.txt", "png"):
            self.sphere_refused(status=USAGE, output=name)

    def test_an_empty_name_shows_in_the_message(self):
        self.sphere_refused(status=USAGE, output="")

    def test_picture_and_scene_do_not_share_a_file(self):
        self.sphere_refused("--save-scene", "old.png", status=USAGE)

    def test_a_pixel_must_be_named_and_lie_in_the_picture(self):
        self.refused("explain", "phantom:sphere", status=USAGE, about="--pixel")
        for pixel in ("1", "1,", ",1", "a,b", "1.5,2", "1,2,3", "1:2", "8,0", "0,8", "-1,0",
                      "1, 2"):
            self.refused("explain", "phantom:sphere", "--size", "8x8", f"--pixel={pixel}",
                         status=USAGE, about="--pixel")

    def test_options_that_do_not_go_with_again(self):
        self.render("phantom:sphere,size=9", name="made.png", size="8x8")
        for words in (["--size", "8x8"], ["--exposure", "2"], ["--save-scene", "s.json"],
                      ["--scene", "s.json"], ["--light", "directional,to=0:0:1"]):
            self.render_refused("--again", "made.png", *words, status=USAGE, about=words[0])
        self.render_refused("--again", "made.png", "a.nrrd", "b.nrrd", status=USAGE)


class WrongInputs(Refusals):
    def unreadable(self, name, *words, about=None, status=WORK, **how):
        about = str(name) if about is None else about
        with self.subTest([name, *words]):
            self.refused("info", name, *words, status=status, about=about, **how)
            self.render_refused(name, "--size", "8x8", *words, status=status, about=about, **how)

    def header(self, text, data=b"", name="bad.nrrd"):
        (self.folder / name).write_bytes(text.encode() + b"\n" + data)
        return name

    def test_a_scene_says_each_thing_once(self):
        for text, about in (('{"isolux_scene": 1, "size": [8, 8], "size": [9, 9]}', "'size' twice"),
                            ('{"isolux_scene": 1, "camera": {"fov": 3, "fov": 4}}', "'fov' twice")):
            (self.folder / "twice.json").write_text(text)
            self.render_refused("phantom:sphere", "--scene", "twice.json", status=USAGE,
                                about=about)
        (self.folder / "once.json").write_text(  # two objects may share a key
            '{"isolux_scene": 1, "size": [8, 8], "surface": [{"iso": 0.5}, {"iso": 0.6}]}')
        self.run_isolux("render", "phantom:sphere", "--scene", "once.json", "-o", "once.png")

    @without_sanitizers
    def test_a_lack_of_file_handles_is_not_called_damage(self):
        scan = self.folder / "slices"
        scan.mkdir()
        (scan / "a.dcm").write_bytes(b"\0" * 128 + b"DICM" + bytes(100))

        def few_files():
            resource.setrlimit(resource.RLIMIT_NOFILE, (5, 5))
        self.refused("info", "slices", status=WORK, about="Too many open files",
                     preexec_fn=few_files)

    def test_missing_files_folders_and_empty_files(self):
        self.unreadable("missing.nrrd")
        (self.folder / "folder").mkdir()
        self.unreadable("folder")
        for name in ("empty.nrrd", "empty.raw", "empty.inv3"):
            (self.folder / name).write_bytes(b"")
            self.unreadable(name)
        self.unreadable("empty.raw", "--dims", "2x2x2", "--type", "u8")

    def test_an_empty_name_shows_in_the_message(self):
        self.render_refused("", status=WORK)

    def test_unknown_formats(self):
        (self.folder / "picture.nrrd").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
        self.unreadable("picture.nrrd")
        self.unreadable("phantom:foot", status=USAGE)
        for size in ("1", "0", "-5", "x", "1e3", "99999999999999999999", ""):
            self.unreadable(f"phantom:sphere,size={size}", status=USAGE)
        self.unreadable("phantom:sphere,sice=5", status=USAGE)

    def test_raw_files_of_another_size(self):
        for size in (26, 28, 27 * 4096):
            (self.folder / "voxels.raw").write_bytes(bytes(size))
            self.unreadable("voxels.raw", "--dims", "3x3x3", "--type", "u8")
        self.unreadable("voxels.raw", "--dims", "1048576x1048576x1048576", "--type", "f32")

    def test_nrrd_cut_short(self):
        values = list(range(64))
        for encoding in ("raw", "gzip"):
            whole = write_nrrd(self.folder / "whole.nrrd", (4, 4, 4), values, encoding=encoding)
            data = whole.read_bytes()
            (self.folder / "whole.nrrd").unlink()
            # The last 8 bytes of a gzip stream are its checksum and length, and hold no voxel.
            for cut in (1 if encoding == "raw" else 12, 20, len(data) - data.index(b"\n\n") - 2, len(data) - 30, len(data) - 5):
                with self.subTest(f"{encoding}, less {cut} bytes"):
                    (self.folder / "cut.nrrd").write_bytes(data[:-cut])
                    self.unreadable("cut.nrrd")

    def test_nrrd_with_damaged_gzip(self):
        write_nrrd(self.folder / "a.nrrd", (16, 16, 16), [n * n % 991 for n in range(4096)],
                   encoding="gzip")
        data = bytearray((self.folder / "a.nrrd").read_bytes())
        middle = (len(data) + data.index(b"\n\n")) // 2
        data[middle:middle + 8] = bytes(8)
        (self.folder / "a.nrrd").write_bytes(data)
        self.unreadable("a.nrrd")
        self.unreadable(self.header(HEADER.replace("raw", "gzip"), b"this is no gzip"))

    def test_nrrd_headers_with_nonsense(self):
        body = voxel_bytes(range(64), "i16")
        directions = "encoding: raw\nspace: LPS\nspace directions:"
        for old, new in [
                ("sizes: 4 4 4", "sizes: 4 4"), ("sizes: 4 4 4", "sizes: 4 4 4 4"),
                ("sizes: 4 4 4", "sizes: 4 4 x"), ("sizes: 4 4 4", "sizes: 4 4 -4"),
                ("sizes: 4 4 4", "sizes: 0 4 4"), ("sizes: 4 4 4", "sizes: 4 4 0"),
                ("sizes: 4 4 4\n", ""), ("type: short\n", ""), ("encoding: raw\n", ""),
                ("type: short", "type: block"), ("type: short", "type: colour"),
                ("encoding: raw", "encoding: zstd"), ("dimension: 3", "dimension: 99"),
                ("dimension: 3", "dimension: -3"), ("dimension: 3\n", ""),
                ("endian: little", "endian: middle"), ("endian: little\n", ""),
                ("encoding: raw", "encoding: raw\nspacings: 0 1 1"),
                ("encoding: raw", "encoding: raw\nspacings: 1 1 1e400"),
                ("encoding: raw", directions + " (1,0,0) (0,1,0) (1,1,0)"),
                ("encoding: raw", directions + " (1,0,0) (0,1,0)"),
                ("encoding: raw", directions + " (1,0,0) (0,1,0) (0,0,0)"),
                ("encoding: raw", "encoding: raw\nspace: nowhere"),
                ("encoding: raw", "encoding: raw\nbyte skip: -7"),
                ("encoding: raw", "encoding: raw\nbyte skip: 99999"),
                ("encoding: raw", "encoding: raw\nline skip: 99999"),
                ("encoding: raw", "encoding: raw\ndata file: nowhere.raw"),
                ("encoding: raw", "encoding: raw\ndata file: part.%d 1 0 0"),
                ("encoding: raw", "encoding: raw\ndata file: LIST\nnowhere.raw"),
                ("encoding: raw", "encoding: raw\nno field here"),
                ("NRRD0004", "NRRDx"), ("NRRD0004", "NRRD9999")]:
            with self.subTest(new):
                self.unreadable(self.header(HEADER.replace(old, new, 1), body))

    def test_volumes_without_a_cell_hold_no_surface(self):
        for dims in ((1, 1, 1), (1, 4, 4), (4, 1, 4), (4, 4, 1)):
            count = math.prod(dims)
            write_nrrd(self.folder / "flat.nrrd", dims, list(range(count)))
            self.render_refused("flat.nrrd", "--surface", "iso=0.5", status=WORK, about="flat.nrrd")

    def test_values_of_a_voxel_that_lie_apart(self):
        planes = HEADER.replace("dimension: 3\nsizes: 4 4 4",
                                "dimension: 4\nsizes: 4 3 4 4\n"
                                "kinds: domain vector domain domain")
        self.unreadable(self.header(planes, bytes(2 * 3 * 64)))

    def test_a_volume_of_one_value_has_no_surface_to_suggest(self):
        write_nrrd(self.folder / "flat.nrrd", (3, 3, 3), [7] * 27)
        self.render_refused("flat.nrrd", status=WORK, about="flat.nrrd")

    @unittest.skipUnless(runs_in_limited_memory(), "this build does not run in limited memory")
    def test_absurd_sizes_in_a_header_are_refused_without_the_memory_for_them(self):
        for sizes in ("100000 100000 100000", "4294967296 4294967296 1", "4294967297 4 4",
                      "9223372036854775807 2 2", "18446744073709551616 1 1", "3000 3000 3000",
                      "2097152 2097152 2097152", "99999999999999999999999999 2 2"):
            for encoding in ("raw", "gzip"):
                text = HEADER.replace("4 4 4", sizes).replace("raw", encoding)
                name = self.header(text, gzip.compress(bytes(2000)))
                self.unreadable(name, preexec_fn=limit_memory)
        self.sphere_refused("--size", "32768x32768", status=USAGE, preexec_fn=limit_memory)
        self.render_refused("phantom:sphere", "--size", "30000x30000", status=WORK,
                            preexec_fn=limit_memory)
        self.render_refused("phantom:sphere,size=4096", status=WORK, preexec_fn=limit_memory)
        (self.folder / "a.raw").write_bytes(bytes(8))
        self.unreadable("a.raw", "--dims", "100000x100000x100000", "--type", "f32",
                        preexec_fn=limit_memory)

    def inv3(self, plist, matrix=bytes(54), name="bad.inv3"):
        with tarfile.open(self.folder / name, "w:gz") as archive:
            for path, data in (("a/main.plist", plist), ("a/matrix.dat", matrix)):
                if data is not None:
                    entry = tarfile.TarInfo(path)
                    entry.size = len(data)
                    archive.addfile(entry, io.BytesIO(data))
        return name

    def test_damaged_invesalius_projects(self):
        good = {"spacing": [1.0, 1.0, 1.0], "modality": "CT", "orientation": 1,
                "matrix": {"filename": "matrix.dat", "dtype": "int16", "shape": [3, 3, 3]}}
        def changed(**changes):
            return plistlib.dumps({**good, **changes})
        def matrix(**changes):
            return changed(matrix={**good["matrix"], **changes})
        self.run_isolux("info", self.inv3(plistlib.dumps(good)))
        for plist in (None, b"", b"no xml", b"<plist/>", plistlib.dumps(good)[:-60],
                      changed(spacing=[1.0, 1.0]), changed(spacing=[1.0, 0.0, 1.0]),
                      changed(spacing=["a", "b", "c"]), changed(matrix={}),
                      matrix(shape=[3, 3]), matrix(shape=[3, 3, 4]), matrix(shape=[0, 3, 3]),
                      matrix(shape=[3, 3, -3]), matrix(shape=[2 ** 40, 2 ** 40, 2 ** 40]),
                      matrix(dtype="complex"), matrix(filename="other.dat"), matrix(filename="")):
            with self.subTest(plist):
                self.unreadable(self.inv3(plist))
        self.unreadable(self.inv3(plistlib.dumps(good), matrix=None))
        self.unreadable(self.inv3(plistlib.dumps(good), matrix=bytes(53)))
        data = (self.folder / self.inv3(plistlib.dumps(good), matrix=bytes(range(54)))).read_bytes()
        for cut in (4, len(data) // 2, len(data) - 12):
            (self.folder / "bad.inv3").write_bytes(data[:-cut])
            self.unreadable("bad.inv3")

    @needs_shared
    def test_every_bad_nrrd_of_the_shared_data_is_refused(self):
        for path in sorted((SHARED / "data/bad/nrrd").iterdir()):
            self.unreadable(path)
        # With its data beside it, an illegal byte skip is still illegal.
        name = "BallBinary30x30x30_byteskip_minus_five.nhdr"
        for source in (f"bad/nrrd/{name}", "nrrd/BallBinary30x30x30.raw"):
            shutil.copy(SHARED / "data" / source, self.folder)
        self.unreadable(name)

    @needs_shared
    def test_bad_files_of_other_formats_are_refused_too(self):
        # Their material file is only named in a comment, and one of their two solids is whole.
        harmless = {"missing_material_file.obj", "triangle_with_empty_solid.stl"}
        for path in sorted((SHARED / "data/bad").glob("*/*")):
            if path.name not in harmless:
                self.unreadable(path)

    @needs_shared
    def test_every_nrrd_of_the_shared_data_is_drawn_or_refused_clearly(self):
        data = SHARED / "data"
        paths = [p for pattern in ("nrrd/*.n*r*", "raw/*.nrrd", "headsq/*.nhdr")
                 for p in sorted(data.glob(pattern))]
        self.assertGreaterEqual(len(paths), 11)
        for path in paths:
            if path.name == "bswap.nrrd":  # 2 x 2 pixels: no cell
                self.render_refused(path, status=WORK, about="bswap.nrrd")
                continue
            self.assertTrue(self.exr(path, size="48x48", camera="view=left").hits(), path.name)


class WrongOutputs(Refusals):
    def test_places_that_cannot_be_written(self):
        (self.folder / "folder.png").mkdir()
        for name in ("missing/a.png", "/proc/a.png", "/proc/1/a.exr", "folder.png",
                     "old.png/a.png"):
            self.sphere_refused(status=WORK, output=name, about=name)

    def test_a_full_disk(self):
        (self.folder / "full.png").symlink_to("/dev/full")
        self.refused("render", "phantom:sphere,size=9", "--size", "8x8", "-o", "full.png",
                     status=WORK, about="full.png")
        with open("/dev/full", "w") as full:
            for words in (["info", "phantom:sphere"], ["manual"], ["--help"],
                          ["explain", "phantom:sphere", "--pixel", "0,0"]):
                self.refused(*words, status=WORK, stdout=full)

    def test_places_for_a_scene_that_cannot_be_written(self):
        for name in ("missing/a.json", "/proc/a.json", "."):
            with self.subTest(name):
                self.sphere_refused("--save-scene", name, status=WORK, about=name)

    def test_a_place_is_tried_before_the_work(self):
        # The volume alone would take minutes.
        self.refused("render", "phantom:head,size=1000", "-o", "missing/a.png", status=WORK,
                     about="missing/a.png")


class NothingToSee(TestCase):
    """No surface is no error: a picture of the background, with a warning."""

    def background(self, *words):
        done = self.run_isolux("render", *words, "--size", "12x12", "--background", "0.5:0.25:1",
                               "-o", "a.exr")
        self.assertIn("warning", done.stderr)
        self.assertFalse(done.stdout)
        exr = read_exr(self.folder / "a.exr")
        self.assertFalse(exr.hits())
        self.assertEqual((set(exr.channels["R"]), set(exr.channels["G"])), ({0.5}, {0.25}))

    def test_an_iso_value_outside_the_range(self):
        for iso in ("2", "-1000", "1e30"):
            self.background("phantom:sphere,size=9", "--surface", f"iso={iso}")

    def test_a_camera_that_looks_away(self):
        self.background("phantom:sphere,size=9", "--camera", "eye=0:-99:0,target=0:-100:0")

    def test_a_volume_of_one_value_at_another(self):
        write_nrrd(self.folder / "flat.nrrd", (3, 3, 3), [7] * 27)
        self.background("flat.nrrd", "--surface", "iso=6")

    def test_voxels_that_are_no_numbers(self):
        write_nrrd(self.folder / "nan.nrrd", (3, 3, 3), [math.nan] * 27, "f32")
        self.background("nan.nrrd", "--surface", "iso=0")

    def test_cells_with_a_corner_that_is_no_number_hold_no_surface_and_others_do(self):
        # j - 1.5 on 4 x 4 x 4 voxels, but for one: the wall at j = 1.5 lacks the cells round it.
        for hole in (math.nan, math.inf, -math.inf):
            values = [j - 1.5 for _ in range(4) for j in range(4) for _ in range(4)]
            values[1 + 4 * (1 + 4 * 1)] = hole
            write_nrrd(self.folder / "hole.nrrd", (4, 4, 4), values, "f32")
            exr = self.exr("hole.nrrd", size="30x30", surface="iso=0",
                           camera="view=front,projection=orthographic,height=3")
            for name, numbers in exr.channels.items():
                self.assertFalse(any(map(math.isnan, numbers)), name)
            for x, y in exr.pixels():
                i, k = (x + 0.5) / 10, (30 - y - 0.5) / 10
                if not math.isnan(hole):
                    continue
                self.assertEqual(exr.at("surface.id", x, y) >= 0, not (i < 2 and k < 2), (i, k))

    def test_info_counts_voxels_that_are_no_numbers(self):
        write_nrrd(self.folder / "nan.nrrd", (3, 3, 3), [math.nan, 1, 2] * 9, "f32")
        told = self.run_isolux("info", "nan.nrrd", "--json").stdout
        self.assertNotIn("nan,", told.lower())
        self.assertIn('"min": 1.0', told)


if __name__ == "__main__":
    unittest.main()
