"""Each room includes only what its row in ARCHITECTURE.md allows, and the page tells the truth."""
import re
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import draw_rooms  # noqa: E402

# Libraries whose headers are heavy or belong to one job: the only files that may include them.
ONLY_IN = {
    r"<nifti/nifti2_io\.h>": {"io/nifti_header.cpp"},
    r"<gdcm": {"io/dicom_parse.cpp"},
    r"<archive(_entry)?\.h>": {"io/read_inv3.cpp", "io/unpacked_archive.cpp",
                                   "io/stored_bytes.cpp"},
    r"<pugixml\.hpp>": {"io/read_inv3.cpp", "io/vti_header.cpp"},
    r"<openssl/": {"io/checksum.cpp"},
    r"<embree3/": {"intersect/mesh_surface.cpp"},
    r"<assimp/": {"io/mesh_import.cpp"},
    r"<jpeglib\.h>": {"image/jpeg.cpp"},
    r"<png\.h>": {"image/png.cpp"},
    r"<boost/": {"server/connection.h", "server/door.cpp", "server/http_connection.cpp",
                 "server/web_socket.cpp"},
    r"<Imf": {"image/exr.cpp"},
    r"<tbb/": {"base/parallel.cpp"},
    r"<meshoptimizer\.h>": {"mesh/simplify_mesh.cpp"},
    r"<CLI/": {"cli/command.cpp"},
}


def allowed_rooms():
    """{room: rooms it may import}, from the table of ARCHITECTURE.md."""
    rows = re.findall(r"^\| `([a-z]+)` \|[^|]*\| ([^|]*) \|$",
                      (ROOT / "ARCHITECTURE.md").read_text(), re.MULTILINE)
    return {room: set(re.findall(r"`([a-z]+)`", may)) for room, may in rows}


def faults(rooms, allowed):
    return [f"{room}/{file} includes {other}"
            for room, files in rooms.items() for file, included in files.items()
            for other in sorted(included - allowed.get(room, set()))]


class Rooms(unittest.TestCase):
    def test_every_room_includes_only_what_its_row_allows(self):
        rooms = draw_rooms.includes_by_room()
        self.assertEqual(set(rooms), set(allowed_rooms()))
        self.assertEqual(faults(rooms, allowed_rooms()), [])

    def test_an_include_against_the_arrows_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            room = Path(folder) / "shade"
            room.mkdir()
            (room / "light.h").write_text('#include "isolux/volume/volume.h"\n')
            rooms = draw_rooms.includes_by_room(Path(folder))
        self.assertEqual(faults(rooms, allowed_rooms()), ["shade/light.h includes volume"])

    def test_the_arrows_run_one_way(self):
        allowed = allowed_rooms()
        order = list(allowed)
        for room, may in allowed.items():
            for other in may:
                self.assertLess(order.index(other), order.index(room), f"{room} -> {other}")

    def test_cmake_links_what_the_table_allows(self):
        text = (ROOT / "src/isolux/CMakeLists.txt").read_text()
        for room, rest in re.findall(r"^isolux_room\((\w+)([^)]*)\)", text, re.MULTILINE):
            linked = re.search(r"ROOMS ([a-z ]+?)(?:\s+LIBRARIES|$)", " ".join(rest.split()))
            names = set(linked.group(1).split()) if linked else set()
            self.assertEqual(names, allowed_rooms()[room], room)

    def test_architecture_shows_the_arrows_as_they_are(self):
        text = draw_rooms.ARCHITECTURE.read_text()
        self.assertEqual(text, draw_rooms.with_diagram(text),
                         "run python3 tools/draw_rooms.py --write")

    def test_heavy_headers_stay_in_their_one_file(self):
        sources = ROOT / "src" / "isolux"
        for path in sorted(sources.rglob("*.h")) + sorted(sources.rglob("*.cpp")):
            if path.name.endswith("_test.cpp"):
                continue
            for header, homes in ONLY_IN.items():
                if re.search(r"#include\s+" + header, path.read_text()):
                    self.assertIn(path.relative_to(sources).as_posix(), homes)

    def test_the_files_named_in_architecture_exist(self):
        text = (ROOT / "ARCHITECTURE.md").read_text()
        for name in re.findall(r"`((?:src|tests|docs|tools|bench)/[\w./-]+)`", text):
            self.assertTrue((ROOT / name).exists(), name)


if __name__ == "__main__":
    unittest.main()
