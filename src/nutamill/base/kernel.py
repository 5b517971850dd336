"""Compile the hot loops: the only room that imports Numba.

Every compiled function of the package is decorated with `kernel`.  The decorator

* stores the compiled code in the user's cache folder (`nutamill.base.compiled_files`) and makes
  `kernel_digest` part of the cache key.  Numba's own key looks at the file of the function alone: after a
  change of a law in one file, a loop in another file would go on running the old physics from the cache
  (`tests/contracts/test_stale_cache.py`), and a second installation would compile everything anew;
* makes the machine code of each kernel complete in itself.  Numba leaves copies of all that a kernel calls
  beside it under public names, and the copy that was loaded first is the one that all kernels run: fast-math
  copies differ in their last bits, so that results would depend on what else a process has compiled or loaded
  before (`tests/contracts/test_same_bits.py`);
* releases the GIL, so that a team of Python threads can run the same kernel;
* counts no references to arrays: kernels allocate nothing, and counting a slice of a shared array is an
  atomic operation that two threads fight over;
* obeys ``NUMBA_DISABLE_JIT=1`` (plain Python, for debugging) and ``NUMBA_BOUNDSCHECK=1``.

Checked with Numba 0.61 to 0.68: private to Numba are `_index_key`, `_impl` and `_cache_path` of its
`FunctionCache`, and `_finalize_final_module` of `JITCodeLibrary`.
"""

import contextlib
import functools
import hashlib
import inspect
import pathlib
import sys
from collections.abc import Callable
from typing import Any

import numba
from llvmlite.binding import Linkage
from numba import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.extending import overload

from nutamill.base.cache_folder import cache_folder
from nutamill.base.compiled_files import CompiledFiles
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


class _CompiledForm(CompileResultCacheImpl):
    """How Numba turns a compiled function into something to store, and back; not where it stores it."""

    def __init__(self):
        pass


class _KernelCache(FunctionCache):
    """The compiled code of one kernel in `CompiledFiles`. What cannot be loaded or stored is compiled."""

    def __init__(self, function):
        self._py_func = function
        self._impl = _CompiledForm()
        self._cache_path = str(cache_folder())
        self._cache_file = CompiledFiles(  # type: ignore[assignment]  # it has the methods of Numba's class
            cache_folder(), f"{function.__module__}.{function.__qualname__}"
        )
        self._source = _source_outside(function)
        self.enable()

    def _index_key(self, sig, codegen):
        versions = (sys.version, numba.__version__, kernel_digest())
        return (*super()._index_key(sig, codegen), self._source, versions)

    def load_overload(self, sig, target_context):
        target_context.refresh()
        try:
            stored = self._cache_file.load(self._index_key(sig, target_context.codegen()))
            return self._impl.rebuild(target_context, stored) if stored is not None else None
        except Exception:  # what another version has stored fails in any way
            return None

    def save_overload(self, sig, data):
        if self._impl.check_cachable(data):
            with contextlib.suppress(OSError):
                self._cache_file.save(self._index_key(sig, data.codegen), dumps(self._impl.reduce(data)))


def _source_outside(function):
    """Return the state of a kernel's file outside this package, which `kernel_digest` does not know, else
    None.
    """
    file = pathlib.Path(inspect.getfile(function))
    if file.resolve().is_relative_to(PACKAGE.resolve()) or not file.is_file():
        return None
    state = file.stat()
    return str(file), state.st_mtime_ns, state.st_size


class _CompleteLibrary(JITCodeLibrary):
    """Machine code of a kernel that calls its own copies of other kernels, and no copy that another one
    brought along.
    """

    def _finalize_final_module(self):
        self._shared_module = (
            self._final_module.clone()
        )  # for kernels that call this one: as Numba makes it, once and later
        for module, before, after in (
            (self._shared_module, Linkage.external, Linkage.linkonce_odr),
            (self._final_module, Linkage.linkonce_odr, Linkage.internal),
        ):
            for function in module.functions:
                if not function.is_declaration and function.linkage == before:
                    function.linkage = after
        super()._finalize_final_module()


class _KernelCompiler(Compiler):
    """Numba's compiler of a function, into a `_CompleteLibrary`."""

    def define_pipelines(self):
        self.state.library = _CompleteLibrary(
            self.state.targetctx.codegen(), self.state.func_id.func_qualname
        )
        self.state.library.enable_object_caching()
        return super().define_pipelines()


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
        "pipeline_class": _KernelCompiler,
    }
    compiled = numba.njit(**options)(function)
    if JIT:
        compiled._cache = _KernelCache(function)
    return compiled


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
    if len(sources) == 0:
        return lambda sources, targets_out: None

    def copy(sources, targets_out):
        copy_numbers(sources[0], targets_out[0])
        copy_arrays(sources[1:], targets_out[1:])

    return copy


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
