"""The source is laid out as .clang-format says, by the version that Debian 12 has."""
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(p for folder in ("src", "tests", "bench") for ending in ("*.h", "*.cpp")
                 for p in (ROOT / folder).rglob(ending))


class Layout(unittest.TestCase):
    def test_every_source_file_is_formatted(self):
        program = shutil.which("clang-format")
        version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout \
            if program else ""
        if not re.search(r"version 14\.", version):
            self.skipTest("clang-format 14 is not here")
        run = subprocess.run([program, "--dry-run", "--Werror", *SOURCES], capture_output=True,
                             text=True, cwd=ROOT)
        self.assertEqual(run.stderr, "")

    def test_no_line_is_longer_than_100_columns(self):
        for path in SOURCES:
            for number, line in enumerate(path.read_text().splitlines(), 1):
                self.assertLessEqual(len(line), 100, f"{path}:{number}")


if __name__ == "__main__":
    sys.exit(unittest.main())
