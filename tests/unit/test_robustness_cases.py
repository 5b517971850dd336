"""300 hostile inputs of each kind: used, or refused in words; `python -m validation.robustness cases` has
more.
"""

import importlib

import pytest

outcomes, cases, meshes = (
    importlib.import_module(f"validation.robustness.{name}") for name in ("outcome", "cases", "meshes")
)


def bad_ones(named):
    """What went wrong, of inputs given as (name, act)."""
    results = ((name, outcomes.outcome(act, longest=20.0)) for name, act in named)
    return [f"{name}: {one.kind}: {one.detail}" for name, one in results if not one.good]


@pytest.mark.parametrize("hostile", [cases.mutants, cases.sampled], ids=["damaged", "extreme"])
def test_hostile_case_files_are_used_or_refused_in_words(hostile):
    assert not bad_ones((case.name, lambda case=case: cases.read(case)) for case in hostile(300, seed=11))


def test_extreme_values_that_are_accepted_get_a_sheet_or_are_refused_in_words():
    """A sheet takes a second, so that five of them are made here."""
    accepted = []
    for case in cases.sampled(300, seed=13):
        if outcomes.outcome(lambda case=case: cases.read(case)).kind == "accepted":
            accepted.append(case)
    cases.checked(accepted[0])  # the compiled kernels are loaded once
    assert not bad_ones((case.name, lambda case=case: cases.checked(case)) for case in accepted[1:6])


def test_hostile_meshes_are_used_or_refused_in_words(caplog):
    assert not bad_ones((name, act) for _, name, act in meshes.attempts(300, seed=17))
    assert not caplog.records  # nor does the library that reads them log a traceback onto the screen


def test_a_fault_in_the_bounds_fails_the_check(monkeypatch):
    """Without bounds of magnitude some extremes end in a traceback or a warning: the sample is sharp enough
    to see it.
    """
    monkeypatch.setattr("nutamill.base.schema.Quantity._beyond", lambda self, si: "")
    named = ((case.name, lambda case=case: cases.read(case)) for case in cases.sampled(300, seed=11))
    assert bad_ones(named)
