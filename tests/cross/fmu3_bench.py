# ruff: noqa: E501
"""A small FMU of FMI 3 that tests compile: a motor of constant torque, and what may go wrong in a step."""

import pathlib
import subprocess
import zipfile

from fmpy import platform_tuple

SOURCE = r"""
#include <stdbool.h>
#include <stdlib.h>
typedef struct { double r[4]; } Instance;
enum { W, M, LATE, FAULT };
#define API __attribute__((visibility("default")))
API const char* fmi3GetVersion(void) { return "3.0"; }
API void* fmi3InstantiateCoSimulation(const char* n, const char* t, const char* p, bool v, bool l, bool e, bool a,
    const unsigned* r, size_t k, void* x, void* g, void* u) {
  Instance* s = calloc(1, sizeof *s); s->r[M] = 0.5; s->r[LATE] = 1e9; return s; }
API void fmi3FreeInstance(void* c) { free(c); }
API int fmi3EnterInitializationMode(void* c, bool h, double t, double s, bool e, double z) { return 0; }
API int fmi3ExitInitializationMode(void* c) { return 0; }
API int fmi3GetFloat64(void* c, const unsigned* v, size_t n, double* x, size_t m) {
  for (size_t k = 0; k < n; k++) x[k] = ((Instance*)c)->r[v[k]]; return 0; }
API int fmi3SetFloat64(void* c, const unsigned* v, size_t n, const double* x, size_t m) {
  for (size_t k = 0; k < n; k++) ((Instance*)c)->r[v[k]] = x[k]; return 0; }
API int fmi3DoStep(void* c, double t, double h, bool none, bool* event, bool* end, bool* early, double* last) {
  Instance* s = c; int fault = t >= s->r[LATE] ? (int)s->r[FAULT] : 0;
  *event = false; *end = fault == 1; *early = fault == 2; *last = fault ? t + h / 2 : t + h;
  return fault == 3 ? 2 : 0; }
#define NONE(name) API int name(void) { return 3; }
NONE(fmi3SetDebugLogging) NONE(fmi3InstantiateModelExchange)
NONE(fmi3InstantiateScheduledExecution) NONE(fmi3EnterEventMode) NONE(fmi3Terminate) NONE(fmi3Reset)
NONE(fmi3GetFloat32) NONE(fmi3GetInt8) NONE(fmi3GetUInt8) NONE(fmi3GetInt16) NONE(fmi3GetUInt16)
NONE(fmi3GetInt32) NONE(fmi3GetUInt32) NONE(fmi3GetInt64) NONE(fmi3GetUInt64) NONE(fmi3GetBoolean)
NONE(fmi3GetString) NONE(fmi3GetBinary) NONE(fmi3GetClock) NONE(fmi3SetFloat32) NONE(fmi3SetInt8)
NONE(fmi3SetUInt8) NONE(fmi3SetInt16) NONE(fmi3SetUInt16) NONE(fmi3SetInt32) NONE(fmi3SetUInt32)
NONE(fmi3SetInt64) NONE(fmi3SetUInt64) NONE(fmi3SetBoolean) NONE(fmi3SetString) NONE(fmi3SetBinary)
NONE(fmi3SetClock) NONE(fmi3GetNumberOfVariableDependencies) NONE(fmi3GetVariableDependencies)
NONE(fmi3GetFMUState) NONE(fmi3SetFMUState) NONE(fmi3FreeFMUState) NONE(fmi3SerializedFMUStateSize)
NONE(fmi3SerializeFMUState) NONE(fmi3DeserializeFMUState) NONE(fmi3GetDirectionalDerivative)
NONE(fmi3GetAdjointDerivative) NONE(fmi3EnterConfigurationMode) NONE(fmi3ExitConfigurationMode)
NONE(fmi3GetIntervalDecimal) NONE(fmi3GetIntervalFraction) NONE(fmi3GetShiftDecimal)
NONE(fmi3GetShiftFraction) NONE(fmi3SetIntervalDecimal) NONE(fmi3SetIntervalFraction)
NONE(fmi3SetShiftDecimal) NONE(fmi3SetShiftFraction) NONE(fmi3EvaluateDiscreteStates)
NONE(fmi3UpdateDiscreteStates) NONE(fmi3EnterContinuousTimeMode) NONE(fmi3CompletedIntegratorStep)
NONE(fmi3SetTime) NONE(fmi3SetContinuousStates) NONE(fmi3GetContinuousStateDerivatives)
NONE(fmi3GetEventIndicators) NONE(fmi3GetContinuousStates) NONE(fmi3GetNominalsOfContinuousStates)
NONE(fmi3GetNumberOfEventIndicators) NONE(fmi3GetNumberOfContinuousStates) NONE(fmi3EnterStepMode)
NONE(fmi3GetOutputDerivatives) NONE(fmi3ActivateModelPartition)
"""
"""Faults: it ends the simulation, returns early, discards the step."""


def write_fmu3(path: pathlib.Path) -> pathlib.Path:
    """Compile the motor and write it as an FMU."""
    source, library = path.with_suffix(".c"), path.with_suffix(".so")
    source.write_text(SOURCE, encoding="utf-8")
    subprocess.run(["cc", "-w", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
    rows = [("w", "input", "continuous"), ("M", "output", "continuous")]
    rows += [("late", "parameter", "fixed"), ("fault", "parameter", "fixed")]
    variables = "".join(
        f'<Float64 name="{name}" valueReference="{k}" causality="{cause}" variability="{vary}"'
        + ("/>" if cause == "output" else ' start="0"/>')
        for k, (name, cause, vary) in enumerate(rows)
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "modelDescription.xml",
            '<?xml version="1.0"?><fmiModelDescription fmiVersion="3.0" modelName="bench" instantiationToken="g">'
            f'<CoSimulation modelIdentifier="bench"/><ModelVariables>{variables}</ModelVariables>'
            '<ModelStructure><Output valueReference="1"/></ModelStructure></fmiModelDescription>',
        )
        archive.writestr(f"binaries/{platform_tuple}/bench.so", library.read_bytes())
    return path
