"""What the README, and every command's --help, shows is run."""
import os
import re
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ISOLUX = os.environ.get("ISOLUX", str(ROOT / "build/release/isolux"))
# As in the README, but small: these tests are about the commands, not the pictures.
SMALL = ["--size", "64x64"]


def readme_commands():
    """The ./isolux lines of the README's block of examples."""
    text = (ROOT / "README.md").read_text()
    block = text.split("## Examples")[1].split("```sh")[1].split("```")[0]
    joined = block.replace("\\\n", " ")
    return [line for line in joined.splitlines() if line.startswith("./isolux")]


def help_commands():
    commands = []
    for command in ("render", "explain", "info", "mesh", "bench"):
        text = subprocess.run([ISOLUX, command, "--help"], capture_output=True, text=True).stdout
        commands += re.findall(r"^  (isolux .*)$", text.split("Examples:")[1], re.MULTILINE)
    return commands


class ShownCommands(unittest.TestCase):
    def run_all(self, commands):
        with tempfile.TemporaryDirectory() as folder:
            for command in commands:
                words = shlex.split(command)
                extra = SMALL if words[1] == "render" and "--again" not in words else []
                run = subprocess.run([ISOLUX, *words[1:], *extra], cwd=folder,
                                     capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, f"{command}\n{run.stderr}")
                if "-o" in words:
                    output = Path(folder) / words[words.index("-o") + 1]
                    self.assertGreater(output.stat().st_size, 0, command)

    def test_the_five_examples_of_the_readme_run(self):
        commands = readme_commands()
        self.assertEqual(len(commands), 5)
        self.run_all(commands)

    def test_the_examples_of_every_help_run(self):
        commands = help_commands()
        self.assertGreaterEqual(len(commands), 5)
        self.run_all([c for c in commands if "--size" in c or c.split()[1] != "bench"])


if __name__ == "__main__":
    unittest.main()
