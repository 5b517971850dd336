"""An exported FMU under FMPy and in a C host without Python, and what a run of the same case records."""

import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from nutamill.simulation.runs import run

HOST = r"""
#include <stdio.h>
#include <stdlib.h>
extern void* fmi2Instantiate(const char*, int, const char*, const char*, const void*, int, int);
extern int fmi2SetupExperiment(void*, int, double, double, int, double);
extern int fmi2EnterInitializationMode(void*); extern int fmi2ExitInitializationMode(void*);
extern int fmi2DoStep(void*, double, double, int);
extern int fmi2GetReal(void*, const unsigned*, size_t, double*);
extern void fmi2FreeInstance(void*);
int main(int c, char** v) {
  int rows = atoi(v[2]), n = c - 4; double h = atof(v[3]), x; unsigned r;
  void* m = fmi2Instantiate("mill", 1, v[1], 0, 0, 0, 0);
  if (!m || fmi2SetupExperiment(m, 0, 0, 0, 0, 0) || fmi2EnterInitializationMode(m)) return 1;
  if (fmi2ExitInitializationMode(m)) return 2;
  for (int k = 0; k <= rows; k++) {
    if (k && fmi2DoStep(m, (k - 1) * h, h, 1)) return 3;
    for (int j = 0; j < n; j++) { r = (unsigned)atoi(v[4 + j]); if (fmi2GetReal(m, &r, 1, &x)) return 4;
      fwrite(&x, 8, 1, stdout); } }
  fmi2FreeInstance(m); return 0; }
"""


def opened(path):
    """Return a started FMU, with `get` and `set` of real numbers, and its value references by name."""
    model = fmpy.read_model_description(str(path))
    second = model.fmiVersion == "2.0"
    unit = (FMU2Slave if second else FMU3Slave)(
        guid=model.guid,
        unzipDirectory=fmpy.extract(str(path)),
        modelIdentifier=model.coSimulation.modelIdentifier,
        instanceName="mill",
    )
    unit.instantiate()
    if second:
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.get, unit.set = unit.getReal, unit.setReal
    else:
        unit.enterInitializationMode(startTime=0.0)
        unit.get, unit.set = unit.getFloat64, unit.setFloat64
    unit.exitInitializationMode()
    return unit, {variable.name: variable.valueReference for variable in model.modelVariables}


def marched(unit, references, count, step, first=0):
    """Return rows (count, n) of an FMU after each of `count` steps, of which `first` are behind it."""
    rows = []
    for k in range(first, first + count):
        unit.doStep(k * step, step)
        rows.append(unit.get(references))
    return np.array(rows)


def recorded_rows(case, path):
    """Run a case, and return names and values (n, n_names) of every series it records."""
    with run(case, to=path) as result:
        names = [name for name in result.series.data_vars if name != "time"]
        return names, np.column_stack([result.series[name].values for name in names])


def unpacked_library(path, folder):
    """Write the only library of an FMU to a folder, and return its path."""
    with zipfile.ZipFile(path) as archive:
        inside = next(name for name in archive.namelist() if name.startswith("binaries/"))
        library = Path(folder) / f"lib{Path(path).stem}.so"
        library.write_bytes(archive.read(inside))
    return library


def rows_in_host(path, folder, names, count, step):
    """Return rows (count + 1, n) of an FMU of FMI 2 that a C program without Python opens and marches."""
    model = fmpy.read_model_description(str(path))
    places = {variable.name: variable.valueReference for variable in model.modelVariables}
    library = unpacked_library(path, folder)
    (folder / "host.c").write_text(HOST, encoding="utf-8")
    command = ["cc", "-w", "-o", "host", "host.c", f"./{library.name}", "-Wl,-rpath,$ORIGIN"]
    subprocess.run(command, cwd=folder, check=True)
    arguments = [model.guid, str(count), repr(step), *(str(places[name]) for name in names)]
    host = [str(folder / "host"), *arguments]
    done = subprocess.run(host, cwd=folder, capture_output=True, env={}, check=True)
    return np.frombuffer(done.stdout).reshape(count + 1, len(names))


class States:
    """What FMPy does with states, by the same names for both versions of FMI."""

    def __init__(self, unit):
        if isinstance(unit, FMU2Slave):
            self.get, self.set, self.free = unit.getFMUstate, unit.setFMUstate, unit.freeFMUstate
            self._store, self.load = unit.serializeFMUstate, unit.deSerializeFMUstate
        else:
            self.get, self.set, self.free = unit.getFMUState, unit.setFMUState, unit.freeFMUState
            self._store, self.load = unit.serializeFMUState, unit.deserializeFMUState

    def store(self, state):
        """Return the bytes of a state."""
        return bytes(self._store(state))
