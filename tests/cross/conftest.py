"""Lets the tests of this folder share their test benches, and those of the unit tests."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.append(str(pathlib.Path(__file__).parents[1] / "unit"))
