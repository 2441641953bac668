#!/usr/bin/env python3
"""Draws the arrows between the rooms of src/isolux from the includes as they are.

    python3 tools/draw_rooms.py           prints a Mermaid diagram
    python3 tools/draw_rooms.py --write   puts it into ARCHITECTURE.md, between its two markers
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ARCHITECTURE = ROOT / "ARCHITECTURE.md"
MARKERS = ("<!-- arrows: tools/draw_rooms.py --write -->\n", "<!-- end of arrows -->\n")
INCLUDE = re.compile(r'^\s*#include\s+"isolux/([a-z]+)/', re.MULTILINE)


def includes_by_room(sources=ROOT / "src" / "isolux"):
    """{room: {file: rooms it includes}}, tests left out."""
    rooms = {}
    for folder in sorted(path for path in sources.iterdir() if path.is_dir()):
        files = [p for p in folder.iterdir() if p.suffix in (".h", ".cpp")]
        rooms[folder.name] = {
            path.name: set(INCLUDE.findall(path.read_text())) - {folder.name}
            for path in sorted(files) if not path.name.endswith("_test.cpp")
        }
    return rooms


def arrows(rooms):
    return {room: sorted(set().union(*files.values())) for room, files in rooms.items()}


def diagram():
    lines = ["```mermaid", "flowchart TD"]
    for room, imported in arrows(includes_by_room()).items():
        lines += [f"  {room} --> {other}" for other in imported] or [f"  {room}"]
    return "\n".join(lines + ["```"]) + "\n"


def with_diagram(text):
    before, rest = text.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    return before + MARKERS[0] + diagram() + MARKERS[1] + after


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        ARCHITECTURE.write_text(with_diagram(ARCHITECTURE.read_text()))
    else:
        print(diagram(), end="")
