"""What every peer is asked and what it answers."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scene import Record, Scene


@dataclass(frozen=True, slots=True)
class Job:
    """One run of one engine from the state of the scene."""

    threads: int
    """Threads, or processes where the engine has no threads [1]."""
    before: int
    """Steps before anything is measured [1]."""
    steps: int
    """Steps of one measured piece [1]."""
    pieces: int = 1
    """Measured pieces [1]."""
    sample: int = 0
    """Steps between two samples of the wrench, with a snapshot after each piece; 0: time is measured and
    nothing else [1].
    """
    patience: float = 600.0
    """Wall time after which the run is given up [s]."""

    def snapshot_times(self, scene: Scene) -> np.ndarray:
        """Times of the snapshots since the state of the scene [s]."""
        return scene.substep * (self.before + self.steps * np.arange(1, self.pieces + 1))


@dataclass(frozen=True, slots=True)
class Outcome:
    """Of one run."""

    time: float
    """Wall time per particle and step [ns]."""
    record: Record | None
    """What was sampled."""


class Peer(Protocol):
    """An engine that can be run."""

    name: str
    """For the table."""
    note: str
    """How what it runs differs from the scene."""
    pace: float
    """Rough time per particle and step on one thread [ns]: how many steps it is given."""

    def run(self, scene: Scene, job: Job) -> Outcome:
        """Run a scene from its state."""


@dataclass(frozen=True, slots=True)
class Missing:
    """An engine that cannot be had."""

    name: str
    """For the table."""
    reason: str
    """Why."""
