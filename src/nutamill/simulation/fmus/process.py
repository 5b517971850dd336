"""The process of its own in which an FMU runs: what it is asked, and its answers.

A request is a length, a letter and bytes on standard input; the answer is a length, "+" or "-" and bytes on
the former standard output.  What the FMU itself prints goes to a file.  Numbers are float64.
"""

import json
import os
import struct
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

PROGRAM = "from nutamill.simulation.fmus.process import serve; serve()"
"""Program of the process."""
LENGTH = struct.Struct("<I")
"""Length of a request or an answer, before it [bytes]."""
STEP, READ, MARK, BACK, STORE, LOAD = b"s", b"i", b"m", b"b", b"w", b"l"
"""Requests: make a step; set the inputs and read; mark the state, go back to the mark; state to bytes, and
back.
"""
PRINTED = "printed.txt"
"""File in the folder of the FMU with what it prints."""


def receive(read: Callable[[int], bytes]) -> bytes:
    """Read a request or an answer. Raise EOFError at the end of the pipe."""

    def whole(count: int) -> bytes:
        parts = b""
        while len(parts) < count:
            if not (part := read(count - len(parts))):
                raise EOFError
            parts += part
        return parts

    return whole(LENGTH.unpack(whole(LENGTH.size))[0])


def _end_with_parent() -> None:
    """Kill this process when its parent has ended, also while the FMU computes."""
    parent = os.getppid()
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


def serve() -> None:
    """Do what the parent asks until it closes the pipe, in the process of an FMU."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    line = b""
    while not line.endswith(b"\n"):  # byte by byte: what follows is a request
        if not (byte := os.read(0, 1)):
            return
        line += byte
    task = json.loads(line)
    folder = Path(task["folder"])
    out = os.dup(1)
    printed = os.open(folder / PRINTED, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(printed, 1)
    os.dup2(printed, 2)

    def answer(mark: bytes, content: bytes) -> None:
        whole = mark + content
        os.write(out, LENGTH.pack(len(whole)))
        while whole:
            whole = whole[os.write(out, whole) :]

    slave: Slave | None = None
    while True:
        try:
            request = receive(lambda count: os.read(0, count))
        except EOFError:
            os._exit(0)  # without the FMU's own farewell, which may hang
        try:
            slave = slave or Slave(task, folder)
            answer(b"+", slave.answer(request[:1], request[1:]))
        except Exception as error:  # whatever FMPy or ctypes raise is an answer
            sys.stdout.flush()
            answer(b"-", str(error).encode())


class Slave:
    """An FMU that has been started, under FMPy.

    Parameters
    ----------
    task : as `nutamill.simulation.fmus.session.FmuSession` writes it
    folder : of the unpacked FMU
    """

    def __init__(self, task: dict[str, Any], folder: Path):
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        self._old = task["version"] == 2
        self._inputs, self._outputs = task["inputs"], task["outputs"]
        self._mark: Any = None
        kind = FMU2Slave if self._old else FMU3Slave
        self._fmu = kind(
            guid=task["token"],
            modelIdentifier=task["identifier"],
            unzipDirectory=str(folder),
            instanceName=task["name"],
        )
        self._fmu.instantiate()
        for reference, type_, value in task["starts"]:
            text = value.encode() if type_ == "String" and self._old else value
            name = "Integer" if type_ == "Enumeration" and self._old else type_
            name = "Int64" if name == "Enumeration" else name
            getattr(self._fmu, f"set{name}")([reference], [text])
        if self._old:
            self._fmu.setupExperiment(startTime=0.0)
            self._fmu.enterInitializationMode()
        else:
            self._fmu.enterInitializationMode(startTime=0.0)
        self._started = False

    def answer(self, request: bytes, content: bytes) -> bytes:
        """Do what is asked and return the bytes of the answer."""
        if request == READ:
            self._set(np.frombuffer(content))
            if not self._started:
                self._fmu.exitInitializationMode()
                self._started = True
            return self._get()
        if request == STEP:
            numbers = np.frombuffer(content)
            self._set(numbers[2:])
            done = self._fmu.doStep(float(numbers[0]), float(numbers[1]))
            if not self._old and done[1]:
                raise RuntimeError(f"it ended the simulation at {done[3]:.9g} s")
            if not self._old and done[2]:
                raise RuntimeError(f"it stopped at {done[3]:.9g} s, before the end of the step")
            return self._get()
        if request == MARK:
            former, self._mark = self._mark, self._state()
            if former is not None:
                self._free(former)
            return b""
        if request == BACK:
            self._restore(self._mark)
            return b""
        if request == STORE:
            state = self._state()
            try:
                return bytes(
                    self._fmu.serializeFMUstate(state) if self._old else self._fmu.serializeFMUState(state)
                )
            finally:
                self._free(state)
        if request == LOAD:
            state = (
                self._fmu.deSerializeFMUstate(content)
                if self._old
                else self._fmu.deserializeFMUState(content)
            )
            self._restore(state)
            self._free(state)
            return self._get()
        raise ValueError(request)

    def _set(self, values: np.ndarray) -> None:
        if self._inputs:
            setter = self._fmu.setReal if self._old else self._fmu.setFloat64
            setter(self._inputs, values.tolist())

    def _get(self) -> bytes:
        if not self._outputs:
            return b""
        getter = self._fmu.getReal if self._old else self._fmu.getFloat64
        return np.array(getter(self._outputs), float).tobytes()

    def _state(self) -> Any:
        return self._fmu.getFMUstate() if self._old else self._fmu.getFMUState()

    def _restore(self, state: Any) -> None:
        (self._fmu.setFMUstate if self._old else self._fmu.setFMUState)(state)

    def _free(self, state: Any) -> None:
        (self._fmu.freeFMUstate if self._old else self._fmu.freeFMUState)(state)
