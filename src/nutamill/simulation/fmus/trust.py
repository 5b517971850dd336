"""An FMU is native code of somebody else: what is shown of it before it is run, and who agrees to that."""

from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.simulation.fmus.mapping import FmuPlan, fmu_plans


def fmu_lines(machine: Machine) -> list[str]:
    """Describe the FMUs of a machine for the sheet of `nutamill check`, from their descriptions alone.

    Raises
    ------
    CaseError : every fault of the FMUs and of their mapping
    NotInstalledError : FMPy is missing
    """
    return [line for plan in fmu_plans(machine) for line in _lines(plan)] if machine.fmus else []


def code_lines(machine: Machine) -> list[str]:
    """Return a line for each FMU of a machine: its name, what it is, and the digest of its content."""
    return [f"{plan.name}: {plan.description.title}, SHA-256 {plan.sha256}" for plan in fmu_plans(machine)]


def refuse_untrusted(machine: Machine, trusted: bool) -> None:
    """Raise CaseError with every fault of the FMUs of a machine, or if nobody has agreed to run them."""
    if not machine.fmus:
        return
    lines = code_lines(machine)
    if not trusted:
        raise CaseError(
            *(
                Fault(f"fmus.{line.partition(':')[0]}", f"is native code of {line.partition(': ')[2]}")
                for line in lines
            ),
            Fault(
                "fmus", "are run only where they are trusted", "Give --trust-fmu, or trust_fmu=True in Python"
            ),
        )


def identities(machine: Machine) -> dict[str, str]:
    """Return model, version, program and digest of each FMU by its key, for the provenance of a result."""
    entries = {}
    for plan in fmu_plans(machine) if machine.fmus else []:
        entries[f"{plan.where}"] = plan.description.title
        entries[f"{plan.where}.sha256"] = plan.sha256
    return entries


def _lines(plan: FmuPlan) -> list[str]:
    fmu = plan.description
    state = "its state cannot be stored"
    if fmu.can_roll_back:
        state = "its state can be rolled back" + (" and stored" if fmu.can_serialise else ", not stored")
    if fmu.own_step:
        state += f"; its own step is {shown(fmu.own_step, 'us')}"
    gets = ", ".join(signal.name for signal in plan.inputs) or "nothing"
    gives = ", ".join(signal.name for signal in plan.outputs) or "nothing"
    bare = [
        signal.name
        for signal in (*plan.inputs, *plan.outputs)
        if fmu.variables[signal.name].unit is None and abs(signal.factor) == 1.0
    ]
    lines = [
        f"fmu       {plan.name}: {fmu.title}; SHA-256 {plan.sha256[:12]}; {state}",
        f"          gets {gets}; gives {gives}",
    ]
    return [*lines, f"          without a declared unit, taken as SI: {', '.join(bare)}"] if bare else lines
