"""A kernel has the same bits in the process that compiles it as in all that load it, whatever else they have
loaded.
"""

import os
import subprocess
import sys

import pytest

LOOPS = '''
import math
import sys

import numpy as np

from nutamill.base.kernel import kernel

LANES = 32


@kernel(fast=True)
def batch(a, b, k):
    """A batch of contacts, in sums that the compiler may reorder."""
    total = np.float32(0.0)
    for i in range(LANES):
        u, v, w = a[i] - b[i], a[LANES + i] - b[LANES + i], a[2 * LANES + i] - b[2 * LANES + i]
        d = math.sqrt(u * u + v * v + w * w)
        n0, n1, n2 = u / d, v / d, w / d
        vn = n0 * b[i] + n1 * b[LANES + i] + n2 * b[2 * LANES + i]
        f = k * d - np.float32(0.3) * vn if d > np.float32(0.4) else k * vn
        t0, t1, t2 = b[i] - vn * n0, b[LANES + i] - vn * n1, b[2 * LANES + i] - vn * n2
        t = math.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
        share = f * np.float32(0.1) / t if t * k > f else k
        a[3 * LANES + i] = f * n0 - share * t0
        a[4 * LANES + i] = f * n1 - share * t1
        a[5 * LANES + i] = f * n2 - share * t2
        total += f * vn + share * t * t
    return total


@kernel(fast=True)
def batches(a, b, k):
    """Some batches, one after another."""
    total = np.float32(0.0)
    for j in range(5):
        total += batch(a, b, k + b[j]) * b[j]
        for e in range(3 * LANES):
            a[e] += a[3 * LANES + e] * np.float32(0.001)
    return total


@kernel
def window(a, b, k):
    """A loop over both."""
    total = 0.0
    for _ in range(3):
        total += batches(a, b, k)
        total -= batch(a, b, np.float32(0.2))
    return total


rng = np.random.default_rng(1)
a, b = rng.random(6 * LANES).astype(np.float32), rng.random(6 * LANES).astype(np.float32)
for name in sys.argv[1:]:
    print(name, float(globals()[name](a.copy(), b.copy(), np.float32(0.3))).hex())
'''


@pytest.fixture
def bits(tmp_path):
    """The printed numbers of these kernels, called in this order in a process of its own."""
    (tmp_path / "loops.py").write_text(LOOPS, encoding="utf-8")

    def run(*names):
        surroundings = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        command = [sys.executable, "-P", str(tmp_path / "loops.py"), *names]
        printed = subprocess.run(command, env=surroundings, capture_output=True, text=True, check=True).stdout
        return dict(line.split() for line in printed.splitlines())

    return run


def test_a_loop_has_the_same_bits_whoever_compiled_it_and_whatever_was_loaded_before(bits):
    compiled = bits("window")
    assert bits("window") == compiled
    after_others = bits("batch", "batches", "window")
    assert after_others["window"] == compiled["window"]
