"""VTK's image files in every form that VTK writes, and the refusal of what is not read."""

import base64
import json
import random
import struct
import unittest
import zlib

from isolux import SHARED, WORK, TestCase, needs_shared

COUNT = 5 * 4 * 3
TYPES = {"UInt8": "B", "Int16": "h", "UInt16": "H", "Float32": "f", "Int32": "i", "Float64": "d"}
GRID = 'WholeExtent="2 6 -1 2 0 2" Origin="10 20 30" Spacing="2 3 4"'


class Vti(TestCase):
    def values(self, kind):
        dice = random.Random(kind)
        return [dice.randrange(200) for _ in range(COUNT)]

    def packed(self, values, kind, order, width, deflated):
        """Header and data of a binary array, as VTK lays them out."""
        data = struct.pack(f"{order}{COUNT}{TYPES[kind]}", *values)
        number = order + ("Q" if width == "UInt64" else "I")
        if not deflated:
            return struct.pack(number, len(data)), data
        block = 50
        blocks = [zlib.compress(data[n:n + block]) for n in range(0, len(data), block)]
        header = [len(blocks), block, len(data) % block, *map(len, blocks)]
        return b"".join(struct.pack(number, n) for n in header), b"".join(blocks)

    def write(self, array, appended=b"", order="<", width="UInt32", deflated=False, grid=GRID,
              extent="2 6 -1 2 0 2", attributes="", name="a.vti"):
        text = (f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order='
                f'"{"LittleEndian" if order == "<" else "BigEndian"}" header_type="{width}"'
                + (' compressor="vtkZLibDataCompressor"' if deflated else "") + ">\n"
                f'<!-- a <DataArray> in a comment -->\n<ImageData {grid}>\n'
                f'<Piece Extent="{extent}">\n<PointData {attributes}>\n{array}\n</PointData>\n'
                "<CellData></CellData></Piece></ImageData>\n").encode()
        if appended:
            text += appended + b"</AppendedData>\n"
        (self.folder / name).write_bytes(text + b"</VTKFile>\n")

    def array(self, kind, form, content="", more=""):
        end = f">{content}</DataArray>" if content else "/>"
        return f'<DataArray type="{kind}" Name="a" format="{form}" {more}{end}'

    def read(self):
        """The values that are read, after a check of where they lie."""
        found = json.loads(self.run_isolux("info", "a.vti", "--json").stdout)
        self.assertEqual(found["dims"], [5, 4, 3])
        self.assertEqual(found["spacing"], [2, 3, 4])
        self.assertEqual(found["origin"], [10 + 2 * 2, 20 - 3, 30])  # the first point's extent
        self.run_isolux("convert", "a.vti", "a.nii")
        letter = {"u8": "B", "i16": "h", "u16": "H", "f32": "f"}[found["type"]]
        return list(struct.unpack(f"<{COUNT}{letter}", (self.folder / "a.nii").read_bytes()[352:]))

    def test_every_form_holds_the_same_values(self):
        for kind in TYPES:
            values = self.values(kind)
            self.write(self.array(kind, "ascii", " ".join(map(str, values))))
            self.assertEqual(self.read(), values)
            for order in "<>" if kind in ("UInt8", "Int16", "Float64") else "<":
                for width in ("UInt32", "UInt64"):
                    for deflated in (False, True):
                        how = {"order": order, "width": width, "deflated": deflated}
                        with self.subTest(kind, **how):
                            self.check_binary(kind, values, how)

    def check_binary(self, kind, values, how):
        header, data = self.packed(values, kind, **how)
        apart = base64.b64encode(header) + base64.b64encode(data)
        for text in (apart, base64.b64encode(header + data)):
            self.write(self.array(kind, "binary", "\n  " + text.decode() + "\n"), **how)
            self.assertEqual(self.read(), values)
            self.write(self.array(kind, "appended", more='offset="0"'),
                       b'<AppendedData encoding="base64">\n   _' + text, **how)
            self.assertEqual(self.read(), values)
        self.write(self.array(kind, "appended", more='offset="3"'),
                   b'<AppendedData encoding="raw">_<>&' + header + data, **how)
        self.assertEqual(self.read(), values)

    def test_axes_may_be_turned(self):
        self.write(self.array("UInt8", "ascii", " ".join(["1", "2"] * 30)),
                   grid=GRID + ' Direction="0 -1 0 1 0 0 0 0 1"')
        found = json.loads(self.run_isolux("info", "a.vti", "--json").stdout)
        self.assertEqual(found["direction"], [0, -1, 0, 1, 0, 0, 0, 0, 1])
        # point (2, -1, 0): two steps of 2 mm along +y, one of 3 mm along -(-x)
        self.assertEqual(found["origin"], [10 + 3, 20 + 4, 30])

    def test_the_scalars_are_read_among_several_arrays(self):
        values = self.values("UInt8")
        other = '<DataArray type="Float32" Name="b" format="ascii">1 2</DataArray>'
        self.write(other + self.array("UInt8", "ascii", " ".join(map(str, values))),
                   attributes='Scalars="a"')
        self.assertEqual(self.read(), values)

    def test_what_is_not_read_or_damaged_is_refused(self):
        data = "".join(f"{n} " for n in range(COUNT))
        good = self.array("UInt8", "ascii", data)

        def refused(about, array=good, **how):
            with self.subTest(about):
                self.write(array, **how)
                self.refused("info", "a.vti", status=WORK, about=about)
        refused("several arrays", good + good.replace('"a"', '"b"'))
        refused("promises", good.replace("Name", 'NumberOfComponents="3" Name'))
        refused("0 values a voxel", good.replace("Name", 'NumberOfComponents="0" Name'))
        refused("no values at its points", "")
        refused("only a part", extent="2 5 -1 2 0 2")
        refused("WholeExtent", grid=GRID.replace("2 6", "6 2"))
        refused("WholeExtent", grid=GRID.replace("2 6 -1 2 0 2", "2 6 -1 2"))
        refused("cannot be placed", grid=GRID.replace("2 3 4", "2 0 4"))
        refused("'x'", good.replace(" 7 ", " x "))
        refused("'300'", good.replace(" 7 ", " 300 "))
        refused("missing", good.replace(" 7 ", " "))
        refused("String", good.replace("UInt8", "String"))
        refused("behind the end", self.array("UInt8", "appended", more='offset="999999"'),
                appended=b'<AppendedData encoding="raw">_')
        refused("appended data are missing", self.array("UInt8", "appended", more='offset="0"'))
        refused("not those of its grid", self.array("UInt8", "appended", more='offset="0"'),
                appended=b'<AppendedData encoding="raw">_' + struct.pack("<I", 61) + bytes(61))
        self.write(good)
        text = (self.folder / "a.vti").read_text()
        for old, new, about in (('type="ImageData"', 'type="PolyData"', "PolyData"),
                                ('header_type="UInt32"', 'compressor="vtkLZ4DataCompressor"', "LZ4"),
                                ("</PointData>", "", "XML"), ("</VTKFile>", "", "XML")):
            (self.folder / "a.vti").write_text(text.replace(old, new))
            self.refused("info", "a.vti", status=WORK, about=about)

    def test_a_grid_that_its_bytes_cannot_fill_is_refused_before_anything_is_allocated(self):
        for form, more in (("ascii", ""), ("binary", "")):
            self.write(self.array("Float64", form, "AAAA", more),
                       grid=GRID.replace("2 6 -1 2 0 2", "0 99999 0 99999 0 99999"),
                       extent="0 99999 0 99999 0 99999")
            self.refused("info", "a.vti", status=WORK, about="promises")

    @needs_shared
    def test_a_file_that_vtk_wrote(self):
        found = json.loads(
            self.run_isolux("info", SHARED / "data" / "vti" / "neghip.vti", "--json").stdout)
        self.assertEqual((found["dims"], found["type"], found["min"], found["max"]),
                         ([64, 64, 64], "u8", 0, 255))


if __name__ == "__main__":
    unittest.main()
