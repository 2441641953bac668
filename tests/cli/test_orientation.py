"""Left is left: through every named view, and through every reader and layout of a file."""

import io
import itertools
import plistlib
import tarfile
import unittest

from isolux import SHARED, TestCase, needs_shared
from pictures import BLOB_DIMS, blob, grid, voxel_bytes, write_nrrd


class NamedViews(TestCase):
    """phantom:head has a bead on its left ear (+x), at (84, 15, -28) mm, denser than all bone:
    at 1300 HU it stands alone."""

    # view: which world axis the picture's right is, and which its top, with their signs
    VIEWS = {"front": ("+x", "+z"), "back": ("-x", "+z"), "left": ("+y", "+z"),
             "right": ("-y", "+z"), "top": ("-x", "-y"), "bottom": ("+x", "-y")}
    BEAD = {"x": 84, "y": 15, "z": -28}

    def head(self, view, iso):
        return self.exr("phantom:head,size=64", size="48x48", surface=f"iso={iso}",
                        camera=f"view={view},projection=orthographic,height=256")

    def along(self, axis):
        """The bead's place along an axis such as "-x"."""
        return (-1 if axis[0] == "-" else 1) * self.BEAD[axis[1]]

    def test_the_marked_ear_is_on_its_side_of_the_picture_in_every_view(self):
        for view, (right, top) in self.VIEWS.items():
            exr = self.head(view, iso=1300)
            hits = exr.hits()
            self.assertTrue(hits, view)
            self.assertTrue(all(exr.at("position.X", *hit) > 70 for hit in hits), view)
            column, row = (sum(axis) / len(hits) for axis in zip(*hits))
            # The head is centred on the origin: the sign tells the half.
            self.assertEqual(column > 23.5, self.along(right) > 0, f"{view}: left or right")
            self.assertEqual(row < 23.5, self.along(top) > 0, f"{view}: top or bottom")

    def test_but_for_the_marked_ear_the_outline_of_the_head_is_its_own_mirror_image(self):
        for view, half in (("front", range(24, 48)), ("back", range(24)), ("top", range(24)),
                           ("bottom", range(24, 48))):
            hits = set(self.head(view, iso=-300).hits())
            alone = [(x, y) for x, y in hits if (47 - x, y) not in hits]
            self.assertTrue(alone, view)
            self.assertTrue(all(x in half for x, _ in alone), view)

    def test_the_face_looks_to_anterior(self):
        # The tip of the nose is the foremost place (least y) of the upright head, on the mid-plane.
        exr = self.head("front", iso=-300)
        nose = min(exr.hits(), key=lambda hit: exr.at("position.Y", *hit))
        self.assertLess(abs(exr.at("position.X", *nose)), 10)
        self.assertLess(exr.at("position.Y", *nose), -90)


class Readers(TestCase):
    """One lopsided body on a grid of 1 x 1.5 x 2 mm, written in many ways."""

    SPACING = (1, 1.5, 2)
    MIDDLE = tuple((n - 1) / 2 * s for n, s in zip(BLOB_DIMS, SPACING))
    STEPS = [(1, 0, 0), (0, 1.5, 0), (0, 0, 2)]

    @classmethod
    def setUpClass(cls):
        cls.values = grid(BLOB_DIMS, blob)

    def setUp(self):
        super().setUp()
        write_nrrd(self.folder / "plain.nrrd", BLOB_DIMS, self.values, directions=self.STEPS)

    def seen(self, name, iso=0, middle=MIDDLE, **options):
        """The picture of the body round `middle` (mm), from a side with no symmetry."""
        x, y, z = middle
        return self.png(name, size="64x64", surface=f"iso={iso}",
                        light=f"point,at={x - 40}:{y - 50}:{z + 30}",
                        camera=f"eye={x + 35}:{y - 40}:{z + 25},target={x}:{y}:{z}", **options)

    def assert_same_pixels(self, name, other="plain.nrrd", other_options={}, **options):
        wanted = self.seen(other, **other_options)
        self.assertGreater(len(set(itertools.chain(*wanted.rows))), 50)
        self.assertEqual(self.seen(name, **options).rows, wanted.rows, name)

    def test_mirroring_the_body_changes_the_picture(self):
        mirrored = grid(BLOB_DIMS, lambda i, j, k: blob(BLOB_DIMS[0] - 1 - i, j, k))
        write_nrrd(self.folder / "mirrored.nrrd", BLOB_DIMS, mirrored, directions=self.STEPS)
        self.assertNotEqual(self.seen("mirrored.nrrd").rows, self.seen("plain.nrrd").rows)

    def test_headerless_raw_of_every_type(self):
        for kind, change, iso in (("i16", lambda v: v, 0), ("f32", lambda v: v, 0),
                                  ("u16", lambda v: v + 1000, 1000),
                                  ("u8", lambda v: (v + 1000) // 8, 125)):
            values = [change(v) for v in self.values]
            write_nrrd(self.folder / "wanted.nrrd", BLOB_DIMS, values, directions=self.STEPS)
            for big in (False, True)[:1 if kind == "u8" else 2]:
                (self.folder / "voxels.raw").write_bytes(voxel_bytes(values, kind, big))
                self.assert_same_pixels(
                    "voxels.raw", "wanted.nrrd", {"iso": iso}, iso=iso, dims="17x15x13",
                    type=kind + ("be" if big else ""), spacing="1:1.5:2")

    def test_nrrd_of_every_type_encoding_and_byte_order(self):
        for kind, encoding, big in itertools.product(("i16", "f32", "f64"), ("raw", "gzip"),
                                                     (False, True)):
            write_nrrd(self.folder / "other.nrrd", BLOB_DIMS, self.values, kind, encoding=encoding,
                       big_endian=big, directions=self.STEPS)
            self.assert_same_pixels("other.nrrd")

    def test_nrrd_with_its_data_in_other_files(self):
        for data_file in ("data.raw", "slice.%03d 1 13 1", "down.%d 13 1 -1"):
            for encoding in ("raw", "gzip"):
                write_nrrd(self.folder / "other.nhdr", BLOB_DIMS, self.values, encoding=encoding,
                           directions=self.STEPS, data_file=data_file)
                self.assert_same_pixels("other.nhdr")

    def test_nrrd_with_a_list_of_files(self):
        size = 2 * BLOB_DIMS[0] * BLOB_DIMS[1]
        write_nrrd(self.folder / "other.nhdr", BLOB_DIMS, self.values, directions=self.STEPS,
                   data_file="whole.raw")
        whole = (self.folder / "whole.raw").read_bytes()
        names = [f"part {k}.raw" for k in range(BLOB_DIMS[2])]
        for k, name in enumerate(names):
            (self.folder / name).write_bytes(whole[k * size:(k + 1) * size])
        header = (self.folder / "other.nhdr").read_text().replace("whole.raw", "LIST")
        (self.folder / "other.nhdr").write_text(header + "\n".join(names) + "\n")
        self.assert_same_pixels("other.nhdr")

    def test_a_detached_header_is_read_from_another_folder(self):
        inner = self.folder / "inner"
        inner.mkdir()
        write_nrrd(inner / "other.nhdr", BLOB_DIMS, self.values, directions=self.STEPS,
                   data_file="data.raw")
        self.assert_same_pixels("inner/other.nhdr")

    def test_nrrd_with_bytes_and_lines_to_skip(self):
        write_nrrd(self.folder / "a.nhdr", BLOB_DIMS, self.values, directions=self.STEPS,
                   data_file="a.raw", fields=["byte skip: -1"])
        write_nrrd(self.folder / "b.nhdr", BLOB_DIMS, self.values, directions=self.STEPS,
                   data_file="b.raw", fields=["line skip: 2", "byte skip: 3"])
        for name, before in (("a.raw", b"anything\n"), ("b.raw", b"one\ntwo\nxyz")):
            data = self.folder / name
            data.write_bytes(before + data.read_bytes())
        self.assert_same_pixels("a.nhdr")
        self.assert_same_pixels("b.nhdr")

    def test_nrrd_in_every_space(self):
        for names, signs in ((("left-posterior-superior", "LPS"), (1, 1, 1)),
                             (("right-anterior-superior", "RAS"), (-1, -1, 1)),
                             (("left-anterior-superior", "LAS"), (1, -1, 1))):
            steps = [[s * x for s, x in zip(signs, step)] for step in self.STEPS]
            for space in names:
                write_nrrd(self.folder / "other.nrrd", BLOB_DIMS, self.values, space=space,
                           directions=steps)
                self.assert_same_pixels("other.nrrd")

    def test_nrrd_with_plain_spacings(self):
        write_nrrd(self.folder / "other.nrrd", BLOB_DIMS, self.values,
                   fields=["spacings: 1 1.5 2"])
        self.assert_same_pixels("other.nrrd")

    def test_spacing_given_on_the_command_line_replaces_that_of_the_file(self):
        write_nrrd(self.folder / "other.nrrd", BLOB_DIMS, self.values,
                   directions=[(9, 0, 0), (0, 9, 0), (0, 0, 9)])
        self.assert_same_pixels("other.nrrd", spacing="1:1.5:2")

    def test_permuted_and_flipped_axes_with_their_directions(self):
        wanted = list(itertools.chain(*self.seen("plain.nrrd").rows))
        for axes in itertools.permutations(range(3)):
            for flips in itertools.product((False, True), repeat=3):
                self.write_laid_out("other.nrrd", axes, flips)
                found = list(itertools.chain(*self.seen("other.nrrd").rows))
                off = [abs(a - b) for a, b in zip(found, wanted) if a != b]
                # Rounding: one step of 255, but where a ray grazes an outline.
                self.assertLess(len(off), 0.005 * len(wanted), (axes, flips))
                self.assertLessEqual(sum(o > 1 for o in off), 3 * 2, (axes, flips))

    def write_laid_out(self, name, axes, flips):
        """The body with its stored axes in the order `axes`, each stored backwards if flipped."""
        def value(*stored):
            index = [0, 0, 0]
            for place, axis, flip in zip(stored, axes, flips):
                index[axis] = BLOB_DIMS[axis] - 1 - place if flip else place
            return self.values[index[0] + 17 * (index[1] + 15 * index[2])]
        steps, origin = [], [0, 0, 0]
        for axis, flip in zip(axes, flips):
            steps.append([-x if flip else x for x in self.STEPS[axis]])
            if flip:
                origin[axis] = (BLOB_DIMS[axis] - 1) * self.SPACING[axis]
        dims = [BLOB_DIMS[axis] for axis in axes]
        write_nrrd(self.folder / name, dims, grid(dims, value), directions=steps, origin=origin)

    def write_inv3(self, name, matrix_first=False):
        plist = {"format_version": 1.1, "modality": "CT", "orientation": 1, "name": "blob",
                 "spacing": list(map(float, self.SPACING)), "scalar_range": [-1000, 900],
                 "matrix": {"filename": "matrix.dat", "dtype": "int16",
                            "shape": list(reversed(BLOB_DIMS))}}
        parts = [("blob/main.plist", plistlib.dumps(plist)),
                 ("blob/matrix.dat", voxel_bytes(self.values, "i16"))]
        with tarfile.open(self.folder / name, "w:gz") as archive:
            for path, data in reversed(parts) if matrix_first else parts:
                entry = tarfile.TarInfo(path)
                entry.size = len(data)
                archive.addfile(entry, io.BytesIO(data))

    def test_invesalius_project_runs_x_up_y_down_and_z_up_from_0(self):
        write_nrrd(self.folder / "wanted.nrrd", BLOB_DIMS, self.values,
                   directions=[(1, 0, 0), (0, -1.5, 0), (0, 0, 2)])
        x, y, z = self.MIDDLE
        for matrix_first in (False, True):
            self.write_inv3("project.inv3", matrix_first)
            self.assert_same_pixels("project.inv3", "wanted.nrrd", {"middle": (x, -y, z)},
                                    middle=(x, -y, z))

    @needs_shared
    def test_the_same_ball_in_several_encodings_is_the_same_picture(self):
        scene = {"size": "32x32", "surface": "iso=0.5", "light": "directional,to=1:-2:3"}
        names = ["BallBinary30x30x30.nrrd", "BallBinary30x30x30_gz.nrrd",
                 "BallBinary30x30x30_gz_lineskip.nrrd", "BallBinary30x30x30.nhdr",
                 "BallBinary30x30x30_byteskip_minus_one.nhdr"]
        first, *others = (self.png(SHARED / "data/nrrd" / name, **scene).rows for name in names)
        self.assertGreater(len(set(itertools.chain(*first))), 10)
        for name, rows in zip(names[1:], others):
            self.assertEqual(rows, first, name)


if __name__ == "__main__":
    unittest.main()
