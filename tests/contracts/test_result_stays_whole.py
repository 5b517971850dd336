"""A result file is whole at every instant: under SIGKILL, and on a full disk."""

import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from nutamill.base.errors import ResultError
from nutamill.result import Recorder, open_result

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="kill signals and file size limits are those of POSIX systems"
)

WRITER = """
import sys
import numpy as np
from nutamill.result import Recorder

recorder = Recorder.create(sys.argv[1], "schema = 1", {}, ["time", "crank_angle"], 1000.0, overwrite=True)
print("writing", flush=True)
k = 0
while True:
    rows = np.arange(k, k + 700.0)
    recorder.append(np.stack([rows, 3.0 * rows], axis=1))
    recorder.checkpoint(float(k), {"charge": {"x": np.full(100_000, float(k))}})
    recorder.commit(force=True)
    k += 700
"""

LIMITED = """
import resource, signal, sys
import numpy as np
from nutamill.base.errors import ResultError
from nutamill.result import Recorder, open_result

signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
recorder = Recorder.create(sys.argv[1], "schema = 1", {}, ["time", "crank_angle"], 1000.0)
recorder.append(np.ones((10, 2)))
recorder.commit(force=True)
limit = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (recorder.size + 1000, limit[1]))
recorder.append(np.random.default_rng(1).standard_normal((200_000, 2)))
try:
    recorder.commit(force=True)
except ResultError as error:
    print(error)
with open_result(sys.argv[1]) as result:
    print(len(result.series["time"]))
resource.setrlimit(resource.RLIMIT_FSIZE, limit)
recorder.commit(force=True)
with open_result(sys.argv[1]) as result:
    print(len(result.series["time"]))
"""


def test_killed_writer_leaves_a_readable_file(tmp_path):
    moments = random.Random(1)
    path = tmp_path / "a.h5"
    commits = []
    for _ in range(20):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE)
        writer.stdout.readline()
        time.sleep(moments.uniform(0.0, 0.2))  # the moment of the kill, not a wait for a result
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        writer.stdout.close()
        with open_result(path) as result:
            rows = result.series["time"].values
            assert len(rows) % 700 == 0
            assert np.array_equal(rows, np.arange(len(rows)))
            assert np.array_equal(result.series["crank_angle"], 3.0 * rows)
            if len(rows):
                checkpoint = result.checkpoint()
                assert checkpoint.time == len(rows) - 700
                assert np.all(checkpoint.groups["charge"]["x"] == checkpoint.time)
        commits.append(len(rows) // 700)
    assert max(commits) > 1  # the kills have met writers at work
    Recorder.create(path, "", {}, ["time"], 1.0, overwrite=True)
    assert [file.name for file in tmp_path.iterdir()] == ["a.h5"]  # the next writer has tidied up


def test_full_disk_leaves_the_earlier_file_and_the_samples_can_still_be_saved(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(tmp_path / "a.h5")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    message, before, after = done.stdout.splitlines()
    assert f"{tmp_path / 'a.h5'}: saving needs" in message
    assert "the system limits files to a smaller size" in message
    assert (before, after) == ("10", "200010")
    assert [file.name for file in tmp_path.iterdir()] == ["a.h5"]


def test_commit_is_not_begun_when_the_disk_has_too_little_room(tmp_path, monkeypatch):
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, ["time"], 1.0)
    recorder.append(np.ones((3, 1)))
    monkeypatch.setattr(
        "nutamill.base.atomic_file.shutil.disk_usage", lambda folder: type("Usage", (), {"free": 12345})()
    )
    with pytest.raises(ResultError, match=r"a\.h5: saving needs \S+ MB, 0\.0 MB are free"):
        recorder.commit(force=True)
    monkeypatch.undo()
    recorder.commit(force=True)
    with open_result(tmp_path / "a.h5") as result:
        assert len(result.series["time"]) == 3
