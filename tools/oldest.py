"""Print the oldest releases that pyproject.toml allows of the packages needed to run, as pinned requirements.

python tools/oldest.py > oldest.txt && pip install -r oldest.txt
"""

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def oldest(requirement: str) -> str:
    """Return ``name>=1.2`` as ``name==1.2.*``, so that the latest patch of that release is taken."""
    name, version = re.fullmatch(r"([\w.-]+)>=([\d.]+)", requirement).groups()
    return f"{name}=={version}.*"


if __name__ == "__main__":
    for requirement in tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["dependencies"]:
        print(oldest(requirement))
