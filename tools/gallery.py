"""Run examples and write what they print into docs/printed, from where the gallery takes it.

python tools/gallery.py ribs wear       # or without names: all that have a file there
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PRINTED = ROOT / "docs" / "printed"


def main(names: list[str]) -> None:
    """Run these examples, each in a folder of its own."""
    for name in names or sorted(path.stem for path in PRINTED.glob("*.txt")):
        with tempfile.TemporaryDirectory() as folder:
            example = str(ROOT / "examples" / f"{name}.py")
            done = subprocess.run(
                [sys.executable, example], cwd=folder, stdout=subprocess.PIPE, text=True, check=True
            )
        (PRINTED / f"{name}.txt").write_text(done.stdout, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
