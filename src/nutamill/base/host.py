"""What the machine at hand has: memory and room on its disks."""

import os
import shutil
from pathlib import Path

CGROUP_LIMIT = Path("/sys/fs/cgroup/memory.max")
"""Files in which Linux gives the memory that a container may use."""


def total_memory() -> float | None:
    """Return the memory that this process may use [bytes], that of its container if it has less, or None if
    not known.
    """
    try:
        whole = float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # a system without sysconf
        return None
    try:
        return min(whole, float(CGROUP_LIMIT.read_text()))
    except (OSError, ValueError):  # no container, or one without a limit ("max")
        return whole


def free_disk(path: str | Path) -> float | None:
    """Return the free room [bytes] on the disk where `path` is or will be, or None if not known."""
    path = Path(path).absolute()
    try:
        return float(
            shutil.disk_usage(next(folder for folder in (path, *path.parents) if folder.exists())).free
        )
    except (OSError, StopIteration):
        return None
