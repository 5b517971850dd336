"""Provenance names what made the numbers, in a form that the result file holds."""

import platform

from nutamill.base.provenance import run_provenance
from nutamill.result import Recorder, open_result


def test_provenance_comes_back_from_the_file(tmp_path):
    made = run_provenance(kernel_digest="ab12", seed=3, threads=2)
    Recorder.create(tmp_path / "a.h5", "", made, ["time"], 1.0).close()
    with open_result(tmp_path / "a.h5") as result:
        stored = result.provenance
    assert stored.pop("wall_time") >= 0.0
    assert stored == made
    assert made["kernel_digest"] == "ab12"
    assert (made["seed"], made["threads"]) == (3, 2)
    assert made["python"] == platform.python_version()
    assert made["numpy"]
    assert made["processor"]
