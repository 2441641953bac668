"""The scenes on which docs/indirect.md compares ways to indirect light."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Of the shared test data: not in this tree.
BOX = Path(os.environ.get("SHARED", ROOT / "../shared")) / "data/meshes/cornell_box.obj"


def scenes(box=BOX):
    """Words of `isolux render` by name."""
    return {
        "skull": ["--surface", "iso=300", "--light", "point,at=-120:-560:260", "--camera",
                  "eye=-60:-620:190,target=118:-140:80,fov=24"],
        "Cornell box": [str(box), "--light", "point,at=278:500:279", "--exposure", "0.5",
                        "--camera", "eye=278:273:-800,target=278:273:0,up=0:1:0,fov=39.3"],
    }
