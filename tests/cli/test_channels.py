"""Colours, several values a voxel, and labels: what is made of voxels that are not one measurement."""

import gzip
import json
import struct
import unittest

from isolux import USAGE, TestCase
from pictures import voxel_bytes

# 2 x 3 x 4 voxels in reds, greens and blues, the first of them (200, 100, 50).
COUNT = 24
COLORS = [(200 - n, 100 + n, 50 + 2 * n) for n in range(COUNT)]
# Rec. 709; no sum here ends in .5, so that how halves are rounded does not matter.
GREYS = [int(0.2126 * r + 0.7152 * g + 0.0722 * b + 0.5) for r, g, b in COLORS]
NRRD = "NRRD0004\ntype: {type}\ndimension: 4\nsizes: {count} 2 3 4\nkinds: {kind} domain domain " \
       "domain\nendian: little\nencoding: {encoding}\n\n"


def nifti(datatype, data, intent=0):
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 2, 3, 4, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 68, intent, datatype)
    struct.pack_into("<5f", header, 76, 1, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[344:348] = b"n+1\0"
    return bytes(header) + bytes(4) + data


class ReadTestCase(TestCase):
    def info(self, *words):
        return json.loads(self.run_isolux("info", *words, "--json").stdout)

    def write(self, name, data):
        (self.folder / name).write_bytes(data)

    def values(self, name, *words):
        """The voxels, as convert writes them behind the header of a .nii."""
        self.run_isolux("convert", name, "out.nii", *words)
        letter = {"u8": "B", "i16": "h", "u16": "H", "f32": "f"}[self.info("out.nii")["type"]]
        data = (self.folder / "out.nii").read_bytes()
        begin = int(struct.unpack_from("<f", data, 108)[0])
        return list(struct.unpack(f"<{COUNT}{letter}", data[begin:]))


class Colors(ReadTestCase):
    def check(self, name, data):
        self.write(name, data)
        self.assertIn("its colours were made grey (Rec. 709 luma)", self.info(name)["notes"])
        self.assertEqual(self.values(name), GREYS, name)

    def test_they_are_read_as_their_luma_whatever_the_format(self):
        rgb = bytes(c for color in COLORS for c in color)
        rgba = bytes(c for color in COLORS for c in (*color, 255))
        for kind, data in (("RGB-color", rgb), ("RGBA-color", rgba)):
            words = {"type": "uchar", "count": len(data) // COUNT, "kind": kind}
            header = NRRD.format(**words, encoding="raw").encode()
            self.check("a.nrrd", header + data)
            header = NRRD.format(**words, encoding="hex").encode()
            self.check("a.nrrd", header + data.hex().encode())
        self.check("a.nii", nifti(128, rgb))
        self.check("a.nii.gz", gzip.compress(nifti(2304, rgba)))
        self.check("a.mha", b"ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\n"
                            b"ElementNumberOfChannels = 3\nElementType = MET_UCHAR\n"
                            b"ElementDataFile = LOCAL\n" + rgb)
        self.check("a.vti", b'<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 2 0 3">'
                            b'<Piece Extent="0 1 0 2 0 3"><PointData><DataArray type="UInt8" '
                            b'Name="a" NumberOfComponents="3" format="ascii">'
                            + " ".join(map(str, rgb)).encode()
                            + b"</DataArray></PointData></Piece></ImageData></VTKFile>")


class Vectors(ReadTestCase):
    def test_each_component_is_a_volume_to_choose(self):
        # voxel n holds (n, 10 n, -n)
        numbers = [m for n in range(COUNT) for m in (n, 10 * n, -n)]
        data = voxel_bytes(numbers, "i16")
        for kind in ("list", "vector", "3-vector"):
            for encoding, packed in (("raw", data), ("gzip", gzip.compress(data)),
                                     ("ascii", " ".join(map(str, numbers)).encode())):
                header = NRRD.format(type="short", count=3, kind=kind, encoding=encoding)
                self.write("a.nrrd", header.encode() + packed)
                for volume, factor in enumerate((1, 10, -1)):
                    self.assertEqual(self.values("a.nrrd", "--volume", volume),
                                     [factor * n for n in range(COUNT)], (kind, encoding))
        self.assertIn("has 3 values a voxel: each is a volume", self.info("a.nrrd")["notes"])
        self.refused("info", "a.nrrd", "--volume", "3", status=USAGE, about="has 3 volumes")

    def test_an_axis_without_a_direction_beside_axes_with_one_runs_through_a_voxel(self):
        self.write("a.nrrd", b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 3 4\nspace: LPS\n"
                             b"space directions: none (1,0,0) (0,2,0) (0,0,3)\nencoding: raw\n\n"
                   + bytes(range(2 * COUNT)))
        found = self.info("a.nrrd", "--volume", "1")
        self.assertEqual((found["dims"], found["spacing"]), ([2, 3, 4], [1, 2, 3]))
        self.assertEqual((found["min"], found["max"]), (1, 2 * COUNT - 1))


class Labels(ReadTestCase):
    STATEMENT = "between two labels there is no surface"

    def suggestion(self, name):
        found = self.info(name)
        told = any(self.STATEMENT in note for note in found["notes"])
        return found["suggested_iso"], found["suggested_iso_names"], told

    def test_one_surface_bounds_them_all_where_the_header_or_the_values_say_so(self):
        regions = bytes([0] * 6 + [3] * 10 + [7] * 8)
        noise = bytes(n * 5 % 8 for n in range(COUNT))  # no two neighbours alike
        header = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n"
        labels = ([0.5], ["labels"], True)
        for name, data, wanted in (("a.nrrd", header + b"\n" + regions, labels),
                                   ("b.nrrd", header + b"Segment0_ID:=x\n\n" + noise, labels),
                                   ("c.nii", nifti(2, noise, intent=1002), labels)):
            self.write(name, data)
            self.assertEqual(self.suggestion(name), wanted, name)
        self.write("d.nrrd", header + b"\n" + noise)
        self.assertEqual(self.suggestion("d.nrrd")[1:], (["threshold"], False))


if __name__ == "__main__":
    unittest.main()
