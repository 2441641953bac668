"""The viewer from outside: how it starts, what it refuses, how it ends. tests/web has the rest."""
import os
import re
import signal
import socket
import stat
import subprocess
import unittest
import urllib.request

import isolux
from isolux import SECONDS, USAGE, WORK

URL = re.compile(r"^http://127\.0\.0\.1:(\d+)/#([0-9a-f]{64})$")


class View(isolux.TestCase):
    def start(self, *words, **variables):
        """The running viewer and the match of its URL."""
        environment = {**os.environ, "XDG_STATE_HOME": str(self.folder / "state"), **variables}
        for name in ("DISPLAY", "WAYLAND_DISPLAY", "SSH_CONNECTION"):
            if name not in variables:
                environment.pop(name, None)
        viewer = subprocess.Popen(
            [isolux.PROGRAM, "view", "phantom:sphere", *words], cwd=self.folder, env=environment,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(viewer.communicate)
        self.addCleanup(viewer.kill)
        line = viewer.stdout.readline().strip()
        if not line:
            self.skip_without_page(viewer.communicate(timeout=SECONDS)[1])
        match = URL.match(line)
        self.assertTrue(match, line)
        return viewer, match

    def skip_without_page(self, said):
        if "built without its page" in said:
            self.skipTest("there was no Node.js to build the page")

    def end(self, viewer, how=signal.SIGINT):
        viewer.send_signal(how)
        output, errors = viewer.communicate(timeout=SECONDS)
        self.assertEqual(viewer.returncode, 0, errors)
        return output, errors

    def test_it_prints_one_url_serves_there_and_ends_cleanly(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            viewer, url = self.start("--no-open")
            with urllib.request.urlopen(f"http://127.0.0.1:{url[1]}/", timeout=SECONDS) as reply:
                self.assertEqual(reply.status, 200)
            self.assertEqual(self.end(viewer, how), ("", ""))

    def test_a_second_start_has_the_same_token_and_two_at_once_have_two_ports(self):
        first, url = self.start("--no-open")
        second, other = self.start("--no-open")
        self.assertNotEqual(url[1], other[1])
        self.assertEqual(url[2], other[2])
        token = self.folder / "state/isolux/view-token"
        self.assertEqual(stat.S_IMODE(token.stat().st_mode), 0o600)
        self.end(first)
        self.end(second)

    def test_the_browser_is_opened_without_showing_the_token_to_others(self):
        opener = self.folder / "xdg-open"
        opener.write_text('#!/bin/sh\necho "$@" > "$PWD/opened"\n')
        opener.chmod(0o755)
        viewer, url = self.start(DISPLAY=":99", PATH=f"{self.folder}:{os.environ['PATH']}")
        opened = self.folder / "opened"
        for _ in range(10 * SECONDS):
            if opened.exists() and opened.read_text().strip():
                break
            try:
                viewer.wait(0.1)
            except subprocess.TimeoutExpired:
                pass
        self.end(viewer)
        file = opened.read_text().strip()
        self.assertNotIn(url[2], file)
        self.assertEqual(stat.S_IMODE(os.stat(file).st_mode), 0o600)
        with open(file) as text:
            self.assertIn(url[0], text.read())

    def test_by_ssh_it_says_how_to_come_through(self):
        viewer, url = self.start("--no-open", SSH_CONNECTION="10.0.0.1 1 10.0.0.2 22")
        _, errors = self.end(viewer)
        self.assertIn(f"ssh -N -L {url[1]}:127.0.0.1:{url[1]} ", errors)

    def test_beyond_loopback_it_warns(self):
        viewer, _ = self.start("--no-open", "--host", "0.0.0.0")
        _, errors = self.end(viewer)
        self.assertRegex(errors, r"^isolux: warning: .*0\.0\.0\.0, without encryption")

    def test_what_cannot_be_viewed_is_refused(self):
        said = subprocess.run([isolux.PROGRAM, "view", "missing.nrrd"], capture_output=True,
                              text=True, timeout=SECONDS).stderr
        self.skip_without_page(said)
        self.refused("view", "missing.nrrd", status=WORK, about="missing.nrrd")
        self.refused("view", "phantom:sphere", "--port", "0", status=USAGE, about="--port")
        self.refused("view", "phantom:sphere", "--host", "here", status=USAGE, about="--host")
        self.refused("view", "phantom:sphere", "-o", "a.png", status=USAGE, about="-o")
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            self.refused("view", "phantom:sphere", "--port", port, status=WORK, about=str(port))


if __name__ == "__main__":
    unittest.main()
