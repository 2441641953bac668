"""A program that is ended in the middle of its work leaves nothing behind."""

import os
import signal
import subprocess
import time
import unittest
import zipfile

from isolux import PROGRAM, SECONDS, TestCase

SIDE = 600  # 216 MB of bytes: long enough at work to be caught at it


class Signals(TestCase):
    def ended(self, number, begun, *words):
        """Ends isolux by a signal when `begun()`; the names that are then in the folder."""
        temporary = self.folder / "temporary"
        temporary.mkdir(exist_ok=True)
        process = subprocess.Popen([PROGRAM, *words], cwd=self.folder, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE,
                                   env={**os.environ, "TMPDIR": str(temporary)})
        try:
            until = time.monotonic() + SECONDS
            while not begun() and process.poll() is None and time.monotonic() < until:
                time.sleep(0.0005)
            process.send_signal(number)
            process.communicate(timeout=SECONDS)
        finally:
            process.kill()
        self.assertEqual(process.returncode, -number)
        return sorted(str(p.relative_to(self.folder)) for p in self.folder.rglob("*"))

    def test_while_it_unpacks_and_reads_a_zip(self):
        header = (f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\n"
                  "encoding: raw\n\n")
        with zipfile.ZipFile(self.folder / "a.zip", "w", zipfile.ZIP_STORED) as archive:
            archive.writestr("a.nrrd", header.encode() + bytes(SIDE ** 3))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            left = self.ended(number, lambda: any(self.folder.glob("temporary/*/*")),
                              "info", "a.zip")
            self.assertEqual(left, ["a.zip", "temporary"])

    def test_while_it_writes_its_output(self):
        with open(self.folder / "a.raw", "wb") as file:
            file.truncate(SIDE ** 3)
        (self.folder / "a.nii").write_text("an older file")

        def begun():
            try:
                return any(p.stat().st_size > 0 for p in self.folder.glob(".isolux-*"))
            except FileNotFoundError:  # the probe at the start
                return False
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            left = self.ended(number, begun, "convert", "a.raw", "--dims", f"{SIDE}x{SIDE}x{SIDE}",
                              "--type", "u8", "a.nii")
            self.assertEqual(left, ["a.nii", "a.raw", "temporary"])
            self.assertEqual((self.folder / "a.nii").read_text(), "an older file")


if __name__ == "__main__":
    unittest.main()
