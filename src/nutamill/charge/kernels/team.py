"""A team of threads that runs one kernel together.

Regions of a kernel are parted by a `barrier` that spins for some thousand turns, as the other thread is about
to arrive within microseconds, and then gives its core away: a barrier that only spins collapses where there
are more threads than cores. Numba has no atomic operations on arrays, so three of them are written as LLVM
instructions here.
"""

import os
import platform
import sys
import threading
from collections.abc import Callable

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from nutamill.base.kernel import JIT, kernel

MOST_THREADS = max(4, os.cpu_count() or 1)
"""Largest team there is work space for [1]."""

SPINS = 4000
"""Turns of the spin before a waiting thread yields its core [1]."""

GENERATION = 16
"""Place of the generation counter [1]: a cache line away from the count of arrivals."""

_HAS_PAUSE = platform.machine().lower() in ("x86_64", "amd64", "i686", "i386")
_YIELD = "SwitchToThread" if sys.platform == "win32" else "sched_yield"


def _pointer(context, builder, array_type, array, index):
    return builder.gep(context.make_array(array_type)(context, builder, array).data, [index])


@intrinsic
def _fetch_add(typing_context, array, index, value):
    def code(context, builder, signature, args):
        return builder.atomic_rmw(
            "add", _pointer(context, builder, signature.args[0], args[0], args[1]), args[2], "seq_cst"
        )

    return types.int64(array, types.intp, types.int64), code


@intrinsic
def _load(typing_context, array, index):
    def code(context, builder, signature, args):
        return builder.load_atomic(
            _pointer(context, builder, signature.args[0], args[0], args[1]), "acquire", 8
        )

    return types.int64(array, types.intp), code


@intrinsic
def _store(typing_context, array, index, value):
    def code(context, builder, signature, args):
        builder.store_atomic(
            args[2], _pointer(context, builder, signature.args[0], args[0], args[1]), "release", 8
        )
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), code


@intrinsic
def _pause(typing_context):
    def code(context, builder, signature, args):
        if _HAS_PAUSE:
            builder.call(
                builder.module.declare_intrinsic(
                    "llvm.x86.sse2.pause", (), ir.FunctionType(ir.VoidType(), [])
                ),
                [],
            )
        return context.get_dummy_value()

    return types.void(), code


@intrinsic
def _give_core_away(typing_context):
    def code(context, builder, signature, args):
        call = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.IntType(32), []), _YIELD)
        builder.call(call, [])
        return context.get_dummy_value()

    return types.void(), code


@kernel
def barrier(counters_out, n_threads):
    """Wait until all threads of the team are here.

    Parameters
    ----------
    counters_out : int64 (32,), zero at first; arrivals, and generation a cache line away [1]
    n_threads : size of the team [1]; 1 returns at once
    """
    if n_threads > 1:
        generation = _load(counters_out, GENERATION)
        if _fetch_add(counters_out, 0, 1) == n_threads - 1:
            _store(counters_out, 0, 0)
            _store(counters_out, GENERATION, generation + 1)
        else:
            spins = 0
            while _load(counters_out, GENERATION) == generation:
                _pause()
                spins += 1
                if spins > SPINS:
                    _give_core_away()


@kernel
def thread_share(n, tid, n_threads):
    """Return first and last-plus-one of `n` items for thread `tid`."""
    return n * tid // n_threads, n * (tid + 1) // n_threads


def run_team(function: Callable, args: tuple, n_threads: int) -> None:
    """Call the kernel ``function(*args, tid, n_threads)`` from `n_threads` threads at once, and wait for all
    of them.

    The kernel must release the GIL (every `nutamill.base.kernel.kernel` does) and is compiled before the team
    starts, by whoever calls it first.  Without the compiler the team has one thread.

    Raises
    ------
    whatever a thread raised, after all have ended
    """
    if n_threads == 1 or not JIT:
        function(*args, 0, 1)
        return
    raised = []

    def work(tid):
        try:
            function(*args, tid, n_threads)
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=work, args=(tid,), daemon=True) for tid in range(1, n_threads)]
    for thread in threads:
        thread.start()
    work(0)
    for thread in threads:
        thread.join()
    if raised:
        raise raised[0]
