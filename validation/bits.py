"""Print a digest of ten short runs, to see whether a change of the code changes a bit of a result.

    python -m validation.bits                 all ten cases, a minute or two with compiled kernels
    python -m validation.bits pellets sand    some of them

A digest covers every series and every array of the last snapshot.  Names do not enter it: a renamed series
has the same digest.
"""

import hashlib
import sys
import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

EXAMPLES = Path(__file__).parents[1] / "examples" / "mechanisms"

SHORT = {
    "drive.ramp": "7000 rpm/s",
    "run.threads": 1,
    "run.snapshots.last": "20 ms",
    "run.checkpoint": "50 ms",
}
"""Settings that all mills share: at full speed after a tenth of a second."""

PELLETS = {"charge.mass": "150 g", "run.until": "0.15 s"}

CASES = {
    "empty-rigid": ("numill", {"charge.kind": "none", "mechanism.mounting": "rigid", "run.until": "0.3 s"}),
    "empty-flexible": ("numill", {"charge.kind": "none", "run.until": "0.3 s"}),
    "motor": ("numill", {"charge.kind": "none", "run.until": "0.3 s", "drive.motor.power": "200 W"}),
    "pellets": ("numill", PELLETS),
    "pellets-two-threads": ("numill", PELLETS | {"run.threads": 2}),
    "ribs-iterated": (
        "numill",
        PELLETS | {"chamber.ribs": 12, "run.coupling": "iterated", "run.until": "0.05 s"},
    ),
    "two-sizes": ("numill", PELLETS | {"charge.sizes": [["4 mm", 0.3], ["6 mm", 0.7]]}),
    "sand": ("numill-2025", {"charge.set": "coarse-sand", "charge.count": 400, "run.until": "0.02 s"}),
    "pendulum": (str(EXAMPLES / "pendulum.toml"), {"run.until": "1 s"}),
    "governor": (str(EXAMPLES / "flyball-governor.toml"), {"run.until": "1 s"}),
}
"""Name of a case: its base and what is set."""


def digest(result) -> str:
    """Return the first 16 digits of the SHA-256 of all series and of the last snapshot of `result`."""
    arrays = [np.ascontiguousarray(series.values) for series in result.series.data_vars.values()]
    if len(result.snapshots):
        arrays += [np.ascontiguousarray(array) for array in result.snapshots[-1].values()]
    parts = sorted(hashlib.sha256(f"{a.dtype} {a.shape}".encode() + a.tobytes()).hexdigest() for a in arrays)
    return hashlib.sha256("".join(parts).encode()).hexdigest()[:16]


def main(names: list[str]) -> None:
    """Run the cases `names` and print a line for each."""
    for name in names or CASES:
        base, settings = CASES[name]
        case = nm.load_case(base)
        for key, value in (settings if base.endswith(".toml") else SHORT | settings).items():
            case = case.with_(key, value)
        with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "run.h5") as result:
            print(f"{name:20s} {digest(result)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
