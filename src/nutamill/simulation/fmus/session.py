"""An FMU in a process of its own, as the run uses it: its faults are sentences, and none ends the run's
process.
"""

import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import TextIO, cast

import numpy as np

from nutamill.base.child import start_child
from nutamill.base.errors import StepError, printable
from nutamill.simulation.fmus.archive import check_digest, unpack
from nutamill.simulation.fmus.description import REAL
from nutamill.simulation.fmus.mapping import FmuPlan
from nutamill.simulation.fmus.process import (
    BACK,
    LENGTH,
    LOAD,
    MARK,
    PRINTED,
    PROGRAM,
    READ,
    STEP,
    STORE,
    receive,
)

SHOWN = 300
"""Characters of an FMU's own message that are shown [1]."""


class FmuSession:
    """A started FMU; inputs and outputs are SI, in the order of the plan.

    Parameters
    ----------
    plan : the FMU and its mapping

    Attributes
    ----------
    plan : as given
    """

    def __init__(self, plan: FmuPlan):
        self.plan = plan
        self._in = np.array([signal.factor for signal in plan.inputs])
        self._out = np.array([signal.factor for signal in plan.outputs])
        variables = plan.description.variables
        self._fixed = [
            start
            for start in plan.starts
            if start.type in REAL and variables[start.name].causality == "parameter"
        ]
        self._parameters: np.ndarray | None = None
        self._folder = Path(tempfile.mkdtemp(prefix="nutamill-fmu-"))
        self._process: subprocess.Popen | None = None
        try:
            path, where = plan.description.path, f"{plan.where}.file"
            check_digest(path, plan.sha256, where)
            unpack(path, self._folder, where)
            task = {
                "folder": str(self._folder),
                "version": plan.description.version,
                "token": plan.description.token,
                "identifier": plan.description.identifier,
                "name": plan.name,
                "starts": [(start.reference, start.type, start.value) for start in plan.starts],
                "inputs": [signal.reference for signal in plan.inputs],
                "outputs": [signal.reference for signal in plan.outputs]
                + [start.reference for start in self._fixed],
            }
            self._process = start_child(PROGRAM, task, stdout=subprocess.PIPE)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the process and remove the unpacked FMU."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    pipe.close()
            self._process = None
        shutil.rmtree(self._folder, ignore_errors=True)

    def read(self, inputs: np.ndarray) -> np.ndarray:
        """Set the inputs, end the initialisation if that is still to be done, and return the outputs at the
        start.
        """
        return self._values(self._ask(READ, 0.0, (inputs / self._in).tobytes()), 0.0)

    def step(self, time: float, step: float, inputs: np.ndarray) -> np.ndarray:
        """Make a step of `step` [s] from `time` [s] with constant inputs, and return the outputs at its end.

        Raises
        ------
        StepError : the FMU refuses, gives a number that is not finite, changes a parameter that the case
            gives, or ends
        """
        numbers = np.concatenate([(time, step), inputs / self._in])
        return self._values(self._ask(STEP, time, numbers.tobytes()), time + step)

    def mark(self, time: float) -> None:
        """Store the state inside the FMU, in place of the one stored before."""
        self._ask(MARK, time)

    def back(self, time: float) -> None:
        """Put the FMU back to the stored state."""
        self._ask(BACK, time)

    def stored(self, time: float) -> np.ndarray:
        """Return the state as bytes (n,)."""
        return np.frombuffer(self._ask(STORE, time), np.uint8)

    def load(self, time: float, state: np.ndarray) -> np.ndarray:
        """Put the FMU into a state of `stored`, and return the outputs there."""
        return self._values(self._ask(LOAD, time, state.tobytes()), time)

    def _values(self, content: bytes, time: float) -> np.ndarray:
        numbers = np.frombuffer(content)
        self._check_parameters(numbers[len(self._out) :], time)
        values = numbers[: len(self._out)] * self._out
        if not np.isfinite(values).all():
            bad = self.plan.outputs[int(np.flatnonzero(~np.isfinite(values))[0])].name
            raise StepError(
                f'{self.plan.where}: the output "{bad}" of the FMU is not a finite number at '
                f"t = {time:.9g} s. Look at its start values and inputs."
            )
        return values

    def _check_parameters(self, parameters: np.ndarray, time: float) -> None:
        """Raise StepError if the FMU has changed a parameter that the case gives since it was started."""
        before = self._parameters = parameters if self._parameters is None else self._parameters
        for start, old, new in zip(self._fixed, before, parameters, strict=True):
            if old != new:
                raise StepError(
                    f'{self.plan.where}.start: the FMU changed its parameter "{start.name}" from {old:.9g} '
                    f"to {new:.9g} at t = {time:.9g} s. The run would not be that of the case: an FMU "
                    "changes variables only. Leave the parameter out of start, or export the FMU without it."
                )

    def _ask(self, request: bytes, time: float, content: bytes = b"") -> bytes:
        process = self._process
        assert process is not None
        to, back = cast(TextIO, process.stdin).buffer, cast(TextIO, process.stdout).buffer
        try:
            to.write(LENGTH.pack(len(content) + 1) + request + content)
            to.flush()
            answer = receive(back.read)
        except (EOFError, BrokenPipeError, ConnectionResetError):
            raise StepError(
                f"{self.plan.where}: the process of the FMU ended at t = {time:.9g} s, {self._end()}. The "
                f"fault is the FMU's, not that of this run.{self._printed()}"
            ) from None
        if answer[:1] == b"-":
            text = printable(" ".join(answer[1:].decode(errors="replace").split())[:SHOWN])
            raise StepError(
                f"{self.plan.where}: the FMU refused at t = {time:.9g} s: {text}.{self._printed()}"
            )
        return answer[1:]

    def _end(self) -> str:
        """Return how the process ended."""
        assert self._process is not None
        code = self._process.wait()
        return f"by signal {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"

    def _printed(self) -> str:
        """Return the last line that the FMU printed as a sentence, empty without one."""
        try:
            text = (self._folder / PRINTED).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""
        lines = [line.strip() for line in text.splitlines() if line.strip()]
        return f' It printed last: "{printable(lines[-1][:SHOWN])}".' if lines else ""
