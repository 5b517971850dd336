"""What the runs of an identification gave, by case, beside their result files: these may then be deleted."""

import json
import math
from pathlib import Path
from typing import NamedTuple

from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault
from nutamill.base.kernel import kernel_digest

FILE = "values.json"
"""Name of the file in the folder of an identification."""


class Values(NamedTuple):
    """Values of rows by the digest of their case."""

    file: Path
    """Where they are stored."""
    of_case: dict[str, dict[str, float | None]]
    """What is read from the run of a case, and its value in SI; None where the run has no steady value."""
    kernels: dict[str, str]
    """Digest of the kernels that made the run of a case."""

    def has(self, case: str, reading: str) -> bool:
        """Return whether the value of a run is there."""
        return reading in self.of_case.get(case, {})

    def value(self, case: str, reading: str) -> float:
        """Return the value of a run, NaN where it has none."""
        value = self.of_case.get(case, {}).get(reading)
        return math.nan if value is None else value

    def add(self, case: str, reading: str, value: float) -> None:
        """Add the value of a run of these kernels."""
        self.of_case.setdefault(case, {})[reading] = None if math.isnan(value) else value
        self.kernels.setdefault(case, kernel_digest())

    def others(self) -> int:
        """Return how many runs kernels of another version have made."""
        return sum(digest != kernel_digest() for digest in self.kernels.values())

    def write(self) -> None:
        """Write the file."""
        lines = [
            f"{json.dumps(case)}: {json.dumps([self.kernels[case], values])}"
            for case, values in self.of_case.items()
        ]
        write_whole(self.file, "{\n" + ",\n".join(lines) + "\n}\n")


def read_values(folder: Path) -> Values:
    """Return the values that are stored in the folder of an identification, none where there is no file.

    Raises
    ------
    CaseError : a file that is none of them
    """
    file = folder / FILE
    if not file.exists():
        return Values(file, {}, {})
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        of_case = {case: {str(k): _number(v) for k, v in held.items()} for case, (_, held) in content.items()}
        return Values(file, of_case, {case: str(kernels) for case, (kernels, _) in content.items()})
    except (OSError, ValueError, TypeError, AttributeError) as error:
        what = f"holds no values of runs ({error})"
        raise CaseError(Fault(str(file), what, "Delete it and repeat the command")) from None


def _number(value: object) -> float | None:
    if value is not None and not isinstance(value, float):
        raise TypeError(f"{value!r} is no number")
    return value
