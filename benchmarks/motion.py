"""Time and size of the motion as files: Miura sheets as MP4, GIF, glTF and HTML.

    python -m benchmarks.motion                     prints the table; 60 MP4 frames of 32 x 32 facets may take 60 s
    python -m benchmarks.motion --sizes 8 --frames 5

Every figure is of a process of its own, from reading the design file to having written the animation.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

LIMIT = 60.0  # seconds for 60 MP4 frames of 1,024 facets
FORMATS = ("mp4", "gif", "glb", "html")


def measured(design: Path, facets: int, frames: int, form: str) -> dict[str, Any]:
    """One animation by the command line."""
    out = design.with_suffix(f".{form}")
    command = [sys.executable, "-m", "inverse", "fold", str(design), "--frames", str(frames), "-o", str(out)]
    began = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    seconds = time.perf_counter() - began
    return {
        "design": design.stem,
        "facets": facets,
        "frames": frames,
        "format": form,
        "seconds": seconds,
        "bytes": out.stat().st_size,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[8, 16, 32, 64], help="facets along both sides")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--formats", nargs="+", default=FORMATS, choices=FORMATS)
    parser.add_argument("--out", type=Path, default=None, help="JSON file of the rows")
    options = parser.parse_args()

    import inverse

    rows = []
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{'design':10}{'facets':>8}{'format':>8}{'frames':>8}{'seconds':>9}{'a frame':>10}{'MB':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for size in options.sizes:
            path = Path(folder) / f"{size}x{size}.fold"
            inverse.write(inverse.seeds.grid((size, size), "FL", "FL"), path)
            for form in options.formats:
                row = measured(path, size * size, options.frames, form)
                rows.append(row)
                print(
                    f"{row['design']:10}{row['facets']:8}{form:>8}{row['frames']:8}{row['seconds']:9.1f}"
                    f"{1000 * row['seconds'] / row['frames']:7.0f} ms{row['bytes'] / 1e6:8.1f}",
                    flush=True,
                )
    for row in rows:
        if (row["facets"], row["format"], row["frames"]) == (1024, "mp4", 60):
            print(f"60 MP4 frames of 1,024 facets: {row['seconds']:.1f} s, at most {LIMIT:.0f} s allowed")
    if options.out is not None:
        options.out.write_text(json.dumps({"rows": rows, "limit_s": LIMIT}, indent=1) + "\n")


if __name__ == "__main__":
    main()
