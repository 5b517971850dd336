"""Exported FMUs called in the wrong order, with null pointers, with what is no step: errors, no crash."""

import ctypes
import shutil

import pytest

from nutamill.case import load_case
from nutamill.export.fmu.write import export_machine

fmpy = pytest.importorskip("fmpy", reason="needs the extra fmu")
pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

ERROR = 3
ZERO, ONE, NAN = ctypes.c_double(0.0), ctypes.c_double(1e-3), ctypes.c_double(float("nan"))
COUNT, NUMBER, PLACE = ctypes.c_size_t(1), ctypes.c_double(), ctypes.c_uint(1)
VALUE = (ctypes.byref(PLACE), COUNT, ctypes.byref(NUMBER))
FLAG = ctypes.c_bool(False)
FLAGS = (ctypes.byref(FLAG), ctypes.byref(FLAG), ctypes.byref(FLAG), ctypes.byref(NUMBER))


class Second:
    """FMI 2: its functions with their arguments after the instance."""

    get, set, step = "fmi2GetReal", "fmi2SetReal", "fmi2DoStep"
    enter, leave, end, reset = (
        f"fmi2{name}" for name in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset")
    )
    calls = {  # noqa: RUF012
        "fmi2SetupExperiment": (0, ZERO, ZERO, 0, ZERO),
        enter: (),
        leave: (),
        end: (),
        step: (ZERO, ONE, 1),
        get: VALUE,
        set: VALUE,
    }
    first = ("fmi2SetupExperiment",)

    def steps(self, time, step):
        """Arguments of a step."""
        return time, step, 1

    def make(self, library, token, kind=1):
        """Return an instance, or None."""
        library.fmi2Instantiate.restype = ctypes.c_void_p
        return library.fmi2Instantiate(b"m", kind, token, None, None, 0, 0)


class Third:
    """FMI 3."""

    get, set, step = "fmi3GetFloat64", "fmi3SetFloat64", "fmi3DoStep"
    enter, leave, end, reset = (
        f"fmi3{name}" for name in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset")
    )
    calls = {  # noqa: RUF012
        enter: (FLAG, ZERO, ZERO, FLAG, ZERO),
        leave: (),
        end: (),
        step: (ZERO, ONE, FLAG, *FLAGS),
        get: (*VALUE, COUNT),
        set: (*VALUE, COUNT),
    }
    first = ()

    def steps(self, time, step):
        """Arguments of a step."""
        return time, step, FLAG, *FLAGS

    def make(self, library, token, kind=1):
        """Return an instance, or None; `kind` 0 asks for model exchange."""
        call = library.fmi3InstantiateCoSimulation if kind else library.fmi3InstantiateModelExchange
        call.restype = ctypes.c_void_p
        if not kind:
            return call(b"m", token, None, FLAG, FLAG, None, None)
        more = (FLAG, FLAG, FLAG, FLAG, None, ctypes.c_size_t(0), None, None, None)
        return call(b"m", token, None, *more)


@pytest.fixture(scope="module", params=[2, 3])
def opened_library(request, tmp_path_factory):
    """A library, its token and the calls of its version."""
    machine = load_case("particle-damper", ["charge.kind=none"]).machine
    path = export_machine(machine, tmp_path_factory.mktemp("calls") / "m.fmu", version=request.param)
    folder = fmpy.platform if request.param == 2 else fmpy.platform_tuple
    library = ctypes.CDLL(f"{fmpy.extract(str(path))}/binaries/{folder}/nutamill.so")
    token = fmpy.read_model_description(str(path)).guid.encode()
    return library, token, Second() if request.param == 2 else Third()


def test_every_function_at_every_stage_is_taken_or_refused(opened_library):
    library, token, api = opened_library
    assert api.make(library, token, kind=0) is None
    assert api.make(library, b"another") is None
    allowed = (
        {*api.first, api.enter, api.set},
        {api.leave, api.get, api.set},
        {api.end, api.step, api.get, api.set},
        {api.get},
    )
    stages = (api.enter, api.leave, api.end)
    for stage, may in enumerate(allowed):
        for name, arguments in api.calls.items():
            instance = ctypes.c_void_p(api.make(library, token))
            for before in stages[:stage]:
                assert getattr(library, before)(instance, *api.calls[before]) == 0
            taken = 0 if name in may else ERROR
            assert getattr(library, name)(instance, *arguments) == taken, (stage, name)
            assert getattr(library, name)(None, *arguments) == ERROR
            library[f"fmi{2 if api.first else 3}FreeInstance"](instance)


def started(opened_library):
    """An instance that may make steps."""
    library, token, api = opened_library
    instance = ctypes.c_void_p(api.make(library, token))
    for name in (api.enter, api.leave):
        assert getattr(library, name)(instance, *api.calls[name]) == 0
    return instance


def test_a_variable_that_is_not_there_or_no_input_is_refused(opened_library):
    library, _, api = opened_library
    instance, rest = started(opened_library), api.calls[api.get][3:]
    nothing = ctypes.byref(ctypes.c_uint(10**6))
    assert getattr(library, api.get)(instance, nothing, COUNT, ctypes.byref(NUMBER), *rest) == ERROR
    assert getattr(library, api.get)(instance, None, COUNT, None, *rest) == ERROR
    clock = ctypes.byref(ctypes.c_uint(0))
    assert getattr(library, api.set)(instance, clock, COUNT, ctypes.byref(ONE), *rest) == ERROR
    assert getattr(library, api.set)(instance, ctypes.byref(PLACE), COUNT, ctypes.byref(NAN), *rest) == ERROR


@pytest.mark.parametrize(("time", "step"), [(ZERO, ZERO), (ZERO, NAN), (ONE, ONE)])
def test_after_what_is_no_step_only_a_reset_helps(opened_library, time, step):
    library, _, api = opened_library
    instance = started(opened_library)
    assert getattr(library, api.step)(instance, *api.steps(time, step)) == ERROR
    assert getattr(library, api.step)(instance, *api.steps(ZERO, ONE)) == ERROR
    assert getattr(library, api.reset)(instance) == 0
    for name in (api.enter, api.leave, api.step):
        assert getattr(library, name)(instance, *api.calls[name]) == 0
