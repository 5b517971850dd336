"""Published data that the comparison needs; where they come from is said in `validation/data/SOURCES.md`."""

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent.parent / "data"


def chung_ooi_figure(name: str) -> dict[str, np.ndarray]:
    """Curves of a figure, by their labels: points (n, 2)."""
    curves: dict[str, list[list[float]]] = {}
    for line in (FOLDER / "chung_ooi_2011" / f"{name}.dat").read_text().splitlines():
        if line.startswith("#"):
            points = curves.setdefault(line.strip("# \t"), [])
        elif line.strip():
            points.append([float(number) for number in line.replace(",", " ").split()])
    return {label: np.array(points) for label, points in curves.items()}


def dosta_packing() -> np.ndarray:
    """Places [m] (25000, 3) of the grains of the penetration test of Dosta et al. 2024; all have a radius of
    1 mm.
    """
    with np.load(FOLDER / "dosta_2024" / "penetration_25k.npz", allow_pickle=False) as packing:
        return packing["nanometres"] * 1e-9
