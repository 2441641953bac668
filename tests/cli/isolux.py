"""Runs the program under test, each test in a folder of its own.

ISOLUX names the program (default: this tree's release build), SHARED the folder of shared data.
"""

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import pictures

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = str(Path(os.environ.get("ISOLUX", ROOT / "build/release/isolux")).resolve())
SHARED = Path(os.environ.get("SHARED", ROOT.parent / "shared")).resolve()
SECONDS = 30  # a bound against hanging; nothing here takes more than a few
WORK, USAGE = 1, 2  # exit statuses

without_sanitizers = unittest.skipIf("ASAN_OPTIONS" in os.environ,
                                     "sanitizers take memory and file handles of their own")
needs_shared = unittest.skipUnless((SHARED / "data").is_dir(), f"{SHARED}/data is not here")


def listed(options):
    """Words of a command: {"size": "8x8", "light": [a, b]} is --size 8x8 --light a --light b."""
    words = []
    for name, value in options.items():
        for item in value if isinstance(value, list) else [value]:
            words += ["--" + name.replace("_", "-"), str(item)]
    return words


def options_of(command):
    """The names of the options that `isolux COMMAND --help` lists, and of their fields:
    {"size": [], "light": ["kind", "at", ...]}. A field without a name is the record's kind."""
    text = subprocess.run([PROGRAM, command, "--help"], capture_output=True, text=True).stdout
    options = {}
    for line in text.splitlines():
        if option := re.match(r"  (?:-\w, )?--([\w-]+)", line):
            fields = options[option[1]] = []
        elif field := re.match(r" {10}(\S+)  ", line):
            fields.append(field[1].split("=")[0] if "=" in field[1] else "kind")
    return options


class TestCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="isolux-test-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_isolux(self, *words, status=0, **how):
        """The finished process. Inputs and outputs without a folder lie in self.folder."""
        how = {"cwd": self.folder, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
               "text": True, "timeout": SECONDS, **how}
        words = list(map(str, words))
        done = subprocess.run([PROGRAM, *words], **how)
        self.assertEqual(done.returncode, status, f"isolux {' '.join(words)}\n{done.stderr}")
        return done

    def refused(self, *words, status, about="", **how):
        """Runs what must fail by the contract's rules; the message."""
        done = self.run_isolux(*words, status=status, **how)
        self.assertFalse(done.stdout, "nothing belongs on standard output")
        last = done.stderr.splitlines()[-1]
        self.assertRegex(last, r"^isolux: error: \S.*: \S.*; \S.*$")
        self.assertIn(about, last)
        return last

    def render(self, *inputs, name="picture.exr", **options):
        """Renders, and returns the file's path."""
        self.run_isolux("render", *inputs, "-o", name, *listed(options))
        return self.folder / name

    def exr(self, *inputs, **options):
        return pictures.read_exr(self.render(*inputs, name="picture.exr", **options))

    def png(self, *inputs, **options):
        return pictures.read_png(self.render(*inputs, name="picture.png", **options))

    def explained(self, *inputs, pixel, **options):
        """What `explain --json` says of a pixel (x, y)."""
        at = "%d,%d" % pixel
        done = self.run_isolux("explain", *inputs, "--pixel", at, "--json", *listed(options))
        return json.loads(done.stdout)

    def assert_near(self, found, wanted, relative=1e-4, absolute=1e-6, message=""):
        """Numbers, or sequences of them, up to a share of the wanted one."""
        if isinstance(wanted, (int, float)):
            found, wanted = [found], [wanted]
        self.assertEqual(len(found), len(wanted), message)
        for n, (a, b) in enumerate(zip(found, wanted)):
            self.assertLessEqual(abs(a - b), relative * abs(b) + absolute,
                                 f"number {n}: {a} is not {b}. {message}")
