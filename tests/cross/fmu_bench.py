# ruff: noqa: E501
"""A small FMU that tests compile: a DC motor, a sprung body, and faults on request."""

import pathlib
import subprocess
import zipfile

SOURCE = r"""
#include <math.h>
#include <stdlib.h>
#include <string.h>
typedef struct { double r[26], load[3], before[3]; int fault; double t; } Instance;
enum { W, U, M, I, R, L, K, FX, FY, FZ, PX, PY, PZ, VX, VY, VZ, AX, AY, AZ, STIFF, MASS, LATE, GAIN, DAMP, AT_ONCE, HELD };
#define API __attribute__((visibility("default")))
API const char* fmi2GetTypesPlatform(void) { return "default"; }
API const char* fmi2GetVersion(void) { return "2.0"; }
API int fmi2SetDebugLogging(void* c, int on, size_t n, const char* const* k) { return 0; }
API void* fmi2Instantiate(const char* n, int t, const char* g, const char* l, const void* f, int v, int o) {
  Instance* s = calloc(1, sizeof *s);
  s->r[R] = 2.0; s->r[L] = 0.01; s->r[K] = 0.5; s->r[STIFF] = 1000.0; s->r[MASS] = 2.0;
  s->r[LATE] = 1e9; s->r[GAIN] = 1.0; return s; }
API void fmi2FreeInstance(void* c) { free(c); }
API int fmi2SetupExperiment(void* c, int a, double b, double t, int d, double e) { return 0; }
API int fmi2EnterInitializationMode(void* c) { return 0; }
static void forces(Instance* s) { for (int k = 0; k < 3; k++)
  s->r[AX + k] = (s->r[GAIN] * s->load[k] - s->r[STIFF] * s->r[PX + k] - s->r[DAMP] * s->r[VX + k]) / s->r[MASS]; }
API int fmi2ExitInitializationMode(void* c) { forces(c); return 0; }
API int fmi2Terminate(void* c) { return 0; }
API int fmi2Reset(void* c) { return 0; }
API int fmi2GetReal(void* c, const unsigned* v, size_t n, double* x) {
  for (size_t k = 0; k < n; k++) x[k] = ((Instance*)c)->r[v[k]]; return 0; }
API int fmi2SetReal(void* c, const unsigned* v, size_t n, const double* x) {
  for (size_t k = 0; k < n; k++) ((Instance*)c)->r[v[k]] = x[k]; return 0; }
API int fmi2SetInteger(void* c, const unsigned* v, size_t n, const int* x) { ((Instance*)c)->fault = x[0]; return 0; }
#define NONE(name) API int name(void) { return 0; }
NONE(fmi2GetInteger) NONE(fmi2GetBoolean) NONE(fmi2GetString) NONE(fmi2SetBoolean) NONE(fmi2SetString)
NONE(fmi2GetDirectionalDerivative) NONE(fmi2SetRealInputDerivatives) NONE(fmi2GetRealOutputDerivatives)
NONE(fmi2CancelStep) NONE(fmi2GetStatus) NONE(fmi2GetRealStatus) NONE(fmi2GetIntegerStatus)
NONE(fmi2GetBooleanStatus) NONE(fmi2GetStringStatus)
API int fmi2GetFMUstate(void* c, void** s) { *s = malloc(sizeof(Instance)); memcpy(*s, c, sizeof(Instance)); return 0; }
API int fmi2SetFMUstate(void* c, void* s) { memcpy(c, s, sizeof(Instance)); return 0; }
API int fmi2FreeFMUstate(void* c, void** s) { free(*s); *s = 0; return 0; }
API int fmi2SerializedFMUstateSize(void* c, void* s, size_t* n) { *n = sizeof(Instance); return 0; }
API int fmi2SerializeFMUstate(void* c, void* s, char* b, size_t n) { memcpy(b, s, sizeof(Instance)); return 0; }
API int fmi2DeSerializeFMUstate(void* c, const char* b, size_t n, void** s) {
  *s = malloc(sizeof(Instance)); memcpy(*s, b, sizeof(Instance)); return 0; }
API int fmi2DoStep(void* c, double t, double h, int none) {
  Instance* s = c; double* r = s->r; int n = 20;
  if (t >= r[LATE] && s->fault == 2) return 2;
  if (t >= r[LATE] && s->fault == 3) *(volatile int*)0 = 1;
  for (int k = 0; k < 3; k++) { s->load[k] = r[HELD] ? s->before[k] : r[FX + k]; s->before[k] = r[FX + k]; }
  for (int j = 0; j < n; j++) r[I] += h / n * (r[U] - r[R] * r[I] - r[K] * r[W]) / r[L];
  r[M] = r[K] * r[I];
  double old[3] = { r[AX], r[AY], r[AZ] }; forces(s);
  double a[3] = { r[AX], r[AY], r[AZ] };
  for (int k = 0; k < 3; k++) r[PX + k] += h * r[VX + k] + 0.5 * h * h * (r[AT_ONCE] ? a[k] : old[k]);
  forces(s);
  for (int k = 0; k < 3; k++) r[VX + k] += 0.5 * h * (a[k] + r[AX + k]);
  if (t >= r[LATE] && s->fault == 4) r[R] = 3.0;
  if (t >= r[LATE] && s->fault == 1) r[M] = r[PX] = NAN;
  return 0; }
"""
"""Motor: torque k i, winding L di/dt = U - R i - k w in 20 explicit steps.  Body: a mass on springs that gets
exactly the impulse of the force held over the step; it drifts with its last acceleration, as our own bodies do,
or with ``at_once`` with that of the new force.  With ``held`` it gets the force of the step before, as from a
master that steps both programs at a time.
"""

INPUTS = {"w": "rad/s", "U": "V", "fx": "N", "fy": "N", "fz": "N"}
OUTPUTS = {"M": "N.m", "I": "A"} | {
    f"{name}{axis}": unit for name, unit in (("p", "m"), ("v", "m/s"), ("a", "m/s2")) for axis in "xyz"
}
PARAMETERS = {
    "R": 2.0,
    "L": 0.01,
    "k": 0.5,
    "stiffness": 1000.0,
    "mass": 2.0,
    "late": 1e9,
    "gain": 1.0,
    "damping": 0.0,
    "at_once": 0.0,
    "held": 0.0,
}
ORDER = (
    *("w", "U", "M", "I", "R", "L", "k", "fx", "fy", "fz"),
    *(f"{name}{axis}" for name in "pva" for axis in "xyz"),
    *("stiffness", "mass", "late", "gain", "damping", "at_once", "held"),
)
UNITS = {
    "rad/s": 'rad="1" s="-1"',
    "N": 'kg="1" m="1" s="-2"',
    "N.m": 'kg="1" m="2" s="-2"',
    "m": 'm="1"',
    "m/s": 'm="1" s="-1"',
    "m/s2": 'm="1" s="-2"',
    "V": 'kg="1" m="2" s="-3" A="-1"',
    "A": 'A="1"',
}


def description(version="2.0", kind="CoSimulation", states=True, units=None):
    """Return the model description of the bench."""
    units = {} if units is None else units
    can = str(states).lower()
    scalars = []
    for reference, name in enumerate(ORDER):
        cause = "input" if name in INPUTS else "output" if name in OUTPUTS else "parameter"
        unit = units.get(name, INPUTS.get(name) or OUTPUTS.get(name))
        unit = f' unit="{unit}"' if unit else ""
        start = f' start="{PARAMETERS.get(name, 0.0)}"' if cause != "output" or name[0] in "pv" else ""
        vary = "fixed" if cause == "parameter" else "continuous"
        scalars.append(
            f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{cause}" '
            f'variability="{vary}"><Real{start}{unit}/></ScalarVariable>'
        )
    scalars.append(
        '<ScalarVariable name="fault" valueReference="0" causality="parameter" variability="fixed">'
        '<Integer start="0"/></ScalarVariable>'
    )
    declared = "".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in UNITS.items())
    return (
        f'<?xml version="1.0"?><fmiModelDescription fmiVersion="{version}" modelName="bench" guid="g" version="1.2" '
        f'generationTool="cc"><{kind} modelIdentifier="bench" canGetAndSetFMUstate="{can}" '
        f'canSerializeFMUstate="{can}" canHandleVariableCommunicationStepSize="true"/>'
        f"<UnitDefinitions>{declared}</UnitDefinitions><ModelVariables>{''.join(scalars)}</ModelVariables>"
        "<ModelStructure/></fmiModelDescription>"
    )


def compiled(folder: pathlib.Path) -> bytes:
    """Return the library of the bench."""
    (folder / "bench.c").write_text(SOURCE, encoding="utf-8")
    library = folder / "bench.so"
    command = ["cc", "-O2", "-w", "-shared", "-fPIC", "-o", str(library), str(folder / "bench.c"), "-lm"]
    subprocess.run(command, check=True)
    return library.read_bytes()


def write_fmu(path, library, text=None, platform="linux64", **more):
    """Write the bench as an FMU, with `more` members."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description() if text is None else text)
        archive.writestr(f"binaries/{platform}/bench.so", library)
        for name, content in more.get("members", {}).items():
            archive.writestr(name, content)
    return path
