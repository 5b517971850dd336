"""Compile the hot loops: how a function becomes a kernel, and when what was compiled is used again.

Every compiled function of the package is decorated with `kernel`.  The decorator

* stores the compiled code in the user's cache folder (`nutamill.base.compiled_files`) and makes
  `kernel_digest` part of the cache key.  Numba's own key looks at the file of the function alone: after a
  change of a law in one file, a loop in another file would go on running the old physics from the cache
  (`tests/contracts/test_stale_cache.py`), and a second installation would compile everything anew;
* makes machine code of what Python calls only, complete in itself (`nutamill.base.compiled_forms`);
* releases the GIL, so that a team of Python threads can run the same kernel;
* counts no references to arrays: kernels allocate nothing, and counting a slice of a shared array is an
  atomic operation that two threads fight over;
* obeys ``NUMBA_DISABLE_JIT=1`` (plain Python, for debugging) and ``NUMBA_BOUNDSCHECK=1``.
"""

import functools
import hashlib
import inspect
import pathlib
import sys
from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core.registry import cpu_target
from numba.extending import overload

from nutamill.base.cache_folder import cache_folder
from nutamill.base.compiled_forms import Kernel
from nutamill.base.source_code import PACKAGE, code_digest, compiled_definitions, reached

JIT = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]  # Numba sets it while it is imported
"""False under ``NUMBA_DISABLE_JIT=1``: kernels are plain Python, one thread only, small cases only."""

FAST_MATH = {"nsz", "arcp", "contract", "reassoc"}
"""Rewrites that let a batch of contacts become vector code; NaN and infinity keep their meaning."""


@functools.cache
def kernel_digest() -> str:
    """Return the SHA-256 of the kernels: all compiled definitions and what they reach
    (`nutamill.base.source_code`).

    It is part of the cache key, and of a result's provenance.  A change of comments, docstrings or of
    functions that no kernel reaches leaves it as it is.
    """
    return code_digest(reached(compiled_definitions()))


def compiled_mark(*names: str) -> pathlib.Path:
    """Return the file that stands for compiled kernels in the cache, of these names: there once they have
    been compiled.

    Compiled code belongs to a version of Python and Numba, a processor and `kernel_digest`.
    """
    processor = cpu_target.target_context.codegen().magic_tuple()
    made_for = (
        sys.version,
        numba.__version__,
        processor,
        kernel_digest(),
    )
    return cache_folder() / "-".join(
        ["compiled", hashlib.sha256(repr(made_for).encode()).hexdigest()[:16], *names]
    )


def _source(function):
    """Return what differs between states of a kernel's source: versions, `kernel_digest`, and the state of
    its file if that is outside this package.
    """
    versions = (sys.version, numba.__version__, kernel_digest())
    file = pathlib.Path(inspect.getfile(function))
    if file.resolve().is_relative_to(PACKAGE.resolve()) or not file.is_file():
        return versions
    state = file.stat()
    return *versions, str(file), state.st_mtime_ns, state.st_size


def kernel(function=None, *, fast=False, inline="never"):
    """Compile `function`: ``@kernel`` for exact arithmetic, ``@kernel(fast=True)`` for batched contact
    loops.
    """
    if function is None:
        return functools.partial(kernel, fast=fast, inline=inline)
    options = {
        "nogil": True,
        "error_model": "numpy",
        "fastmath": FAST_MATH if fast else False,
        "inline": inline,
        "no_cfunc_wrapper": True,
        "_nrt": False,
    }
    return Kernel(function, options, functools.partial(_source, function)) if JIT else function


def entry_of(function: Any, *arguments: Any) -> Callable[..., Any]:
    """Return what calls a kernel with arguments of these types, and looks at no type again.

    A call of a kernel looks up the types of its arguments, which takes milliseconds where there are arrays of
    records: too long for one that is called at every window.
    """
    if not JIT:
        return function
    types_of = tuple(function.typeof_pyval(argument) for argument in arguments)
    function.compile(types_of)
    return function.overloads[types_of].entry_point


def like(value, x):
    """Return `value` in the precision of the scalar `x`.

    A Python literal is a float64 and would turn a float32 law into a float64 one; ``like(0.5, x)`` does not.
    """
    return type(x)(value)


@overload(like, inline="always")
def _like(value, x):
    if isinstance(x, types.Float):
        precision = x
        return lambda value, x: precision(value)
    return None


@kernel
def copy_numbers(source, target_out):
    """Copy every number of an array to one of the same shape. An assignment of slices would allocate."""
    numbers, target = source.reshape(source.size), target_out.reshape(target_out.size)
    for k in range(numbers.size):
        target[k] = numbers[k]


def copy_arrays(sources, targets_out):
    """Copy every array of a tuple, named or not, to the array at the same position of another."""
    for source, target in zip(sources, targets_out, strict=True):
        target[...] = source


@overload(copy_arrays, jit_options={"nogil": True, "_nrt": False})  # type: ignore[typeddict-unknown-key]
def _copy_arrays(sources, targets_out):
    # one function for all of them: a step from each array to the next would compile a function for each
    lines = [f"    copy_numbers(sources[{k}], targets_out[{k}])" for k in range(len(sources))]
    space = {"copy_numbers": copy_numbers}
    exec("\n".join(["def copy(sources, targets_out):", *lines, "    return None"]), space)
    return space["copy"]


def by_type(kernels):
    """Return a function that calls the one of `kernels` (type of the first argument: kernel) that its first
    argument selects.

    The type is known when the caller is compiled, so that the caller holds the chosen kernel and no choice.
    The kernels take the same arguments.
    """
    plain = {kind: getattr(chosen, "py_func", chosen) for kind, chosen in kernels.items()}

    def stage(*arguments):
        return plain[type(arguments[0])](*arguments)

    def choose(*arguments):
        return plain.get(getattr(arguments[0], "instance_class", None))

    choose.__signature__ = inspect.signature(next(iter(plain.values())))  # type: ignore[attr-defined]
    overload(stage, inline="always")(choose)
    return stage
