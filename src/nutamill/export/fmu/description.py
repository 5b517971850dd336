"""modelDescription.xml of FMI 2.0 and 3.0, from the declared variables."""

import re
from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

from nutamill import __version__
from nutamill.export.fmu.interface import ExportedVariable, Interface

BASE = {
    "m": {"m": 1},
    "s": {"s": 1},
    "kg": {"kg": 1},
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
}
"""Exponents of the base units of FMI in the units of recorded quantities [1]."""


def unit_name(unit: str) -> str:
    """Return a unit as FMI's examples write it: "N.m", "m/s2"."""
    return unit.replace("^", "").replace(" ", ".").replace("*", ".")


def exponents(unit: str) -> dict[str, int]:
    """Return the exponents of the base units in a unit such as "N m" or "m/s^2" [1]."""
    total: dict[str, int] = {}
    above, *below = unit.split("/")
    for sign, text in ((1, above), *((-1, part) for part in below)):
        for factor in re.split(r"[ *]", text):
            name, _, power = factor.partition("^")
            for base, exponent in BASE.get(name, {}).items():
                total[base] = total.get(base, 0) + sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in total.items() if exponent}


def model_description(interface: Interface, version: int, identifier: str, token: str) -> str:
    """Return the description of a machine for a version of FMI, 2 or 3.

    Parameters
    ----------
    interface : the machine
    version : 2 or 3
    identifier : name of the libraries
    token : what identifies description and library as parts of one FMU
    """
    return (_second if version == 2 else _third)(interface, identifier, token)


def _head(interface: Interface) -> str:
    machine = interface.model.machine
    title = machine.title or machine.name
    return (
        f"modelName={quoteattr(machine.name)} description={quoteattr(title)} "
        f'version="{__version__}" generationTool="nutamill {__version__}" '
        'variableNamingConvention="structured"'
    )


def _units(variables: Iterable[ExportedVariable]) -> str:
    names = dict.fromkeys(variable.unit for variable in variables if variable.unit != "1")
    rows = []
    for unit in names:
        base = "".join(f' {name}="{exponent}"' for name, exponent in exponents(unit).items())
        rows.append(f'    <Unit name="{unit_name(unit)}"><BaseUnit{base}/></Unit>')
    return "\n".join(rows)


def _experiment(interface: Interface) -> str:
    end, step = interface.model.machine.run.end, interface.model.plan.dt
    return f'<DefaultExperiment startTime="0" stopTime="{end!r}" stepSize="{step!r}"/>'


def _second(interface: Interface, identifier: str, token: str) -> str:
    rows, outputs = [], []
    for reference, v in enumerate(interface.variables):
        unit = "" if v.unit == "1" else f' unit="{unit_name(v.unit)}"'
        start = "" if v.start is None else f' start="{v.start!r}"'
        initial = ' initial="calculated"' if v.causality == "output" else ""
        rows.append(
            f'    <ScalarVariable name="{v.name}" valueReference="{reference}" causality="{v.causality}" '
            f'variability="continuous"{initial} description={quoteattr(v.meaning)}><Real{unit}{start}/>'
            "</ScalarVariable>"
        )
        if v.causality == "output":
            outputs.append(f'<Unknown index="{reference + 1}"/>')
    listed = "".join(outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" {_head(interface)} guid="{token}">
  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUstate="true" canSerializeFMUstate="true" canInterpolateInputs="false"
    providesDirectionalDerivative="false"/>
  <UnitDefinitions>
{_units(interface.variables)}
  </UnitDefinitions>
  <LogCategories><Category name="logStatusError"/></LogCategories>
  {_experiment(interface)}
  <ModelVariables>
{chr(10).join(rows)}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{listed}</Outputs>
    <InitialUnknowns>{listed}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _third(interface: Interface, identifier: str, token: str) -> str:
    rows, outputs, unknowns = [], [], []
    for reference, v in enumerate(interface.variables):
        unit = "" if v.unit == "1" else f' unit="{unit_name(v.unit)}"'
        start = "" if v.start is None else f' start="{v.start!r}"'
        initial = ' initial="calculated"' if v.causality == "output" else ""
        rows.append(
            f'    <Float64 name="{v.name}" valueReference="{reference}" causality="{v.causality}" '
            f'variability="continuous"{initial}{unit}{start} description={quoteattr(v.meaning)}/>'
        )
        if v.causality == "output":
            outputs.append(f'<Output valueReference="{reference}"/>')
            unknowns.append(f'<InitialUnknown valueReference="{reference}"/>')
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" {_head(interface)} instantiationToken="{token}">
  <CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUState="true" canSerializeFMUState="true"
    fixedInternalStepSize="{interface.model.plan.dt!r}"/>
  <UnitDefinitions>
{_units(interface.variables)}
  </UnitDefinitions>
  <LogCategories><Category name="logStatusError"/></LogCategories>
  {_experiment(interface)}
  <ModelVariables>
{chr(10).join(rows)}
  </ModelVariables>
  <ModelStructure>
    {"".join(outputs)}
    {"".join(unknowns)}
  </ModelStructure>
</fmiModelDescription>
"""
