"""Compile the hot loops: the only room that imports Numba.

Every compiled function of the package is decorated with `kernel`.  The decorator

* keeps the compiled code in the user's cache folder and makes `kernel_digest` part of the cache key.  Numba's own key looks at
  the file of the function alone: after a change of a law in one file, a loop in another file would go on running the old
  physics from the cache (`tests/contracts/test_stale_cache.py`);
* makes the machine code of each kernel complete in itself.  Numba leaves copies of all that a kernel calls beside it under public names,
  and the copy that was loaded first is the one that all kernels run: fast-math copies differ in their last bits, so that results would
  depend on what else a process has compiled or loaded before (`tests/contracts/test_same_bits.py`);
* releases the GIL, so that a team of Python threads can run the same kernel;
* counts no references to arrays: kernels allocate nothing, and counting a slice of a shared array is an atomic operation that
  two threads fight over;
* obeys ``NUMBA_DISABLE_JIT=1`` (plain Python, for debugging) and ``NUMBA_BOUNDSCHECK=1``.

Checked with Numba 0.61 to 0.68: `_index_key` is a private method of Numba's `FunctionCache`, `_finalize_final_module` one of its
`JITCodeLibrary`.
"""

import functools
import inspect
import os
import pathlib
import sys

import numba
from llvmlite.binding import Linkage
from numba import types
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import overload

from nutamill.source_code import code_digest, compiled_definitions, reached

JIT = not numba.config.DISABLE_JIT
"""False under ``NUMBA_DISABLE_JIT=1``: kernels are plain Python, one thread only, small cases only."""

COMPILER_VERSION = numba.__version__
"""Version of the compiler, for names of what it made."""

FAST_MATH = {"nsz", "arcp", "contract", "reassoc"}
"""Rewrites that let a batch of contacts become vector code; NaN and infinity keep their meaning."""


def cache_folder() -> pathlib.Path:
    """Folder of the compiled kernels: ``NUMBA_CACHE_DIR`` if set, else the user's cache folder."""
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        return pathlib.Path(given)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", pathlib.Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = pathlib.Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    return pathlib.Path(base) / "nutamill" / "kernels"


@functools.cache
def kernel_digest() -> str:
    """Return the SHA-256 of the kernels: all compiled definitions and what they reach (`nutamill.source_code`).

    It is part of the cache key, and of a result's provenance.  A change of comments, docstrings or of functions that no kernel reaches
    leaves it as it is.
    """
    return code_digest(reached(compiled_definitions()))


class _SourceKeyedCache(FunctionCache):
    """Numba's disk cache with the digest of the kernels in its key."""

    def _index_key(self, sig, codegen):
        return (*super()._index_key(sig, codegen), kernel_digest())


class _CompleteLibrary(JITCodeLibrary):
    """Machine code of a kernel that calls its own copies of other kernels, and no copy that another one brought along."""

    def _finalize_final_module(self):
        linked = [function for function in self._final_module.functions if not function.is_declaration and function.linkage == Linkage.linkonce_odr]
        self._shared_module = self._final_module.clone()
        for function in self._shared_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = Linkage.linkonce_odr
        for function in linked:
            function.linkage = Linkage.internal
        super()._finalize_final_module()


class _KernelCompiler(Compiler):
    """Numba's compiler of a function, into a `_CompleteLibrary`."""

    def define_pipelines(self):
        self.state.library = _CompleteLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return super().define_pipelines()


if not numba.config.CACHE_DIR:
    numba.config.CACHE_DIR = str(cache_folder())


def kernel(function=None, *, fast=False, inline="never"):
    """Compile `function`: ``@kernel`` for exact arithmetic, ``@kernel(fast=True)`` for batched contact loops."""
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
        compiled._cache = _SourceKeyedCache(function)
    return compiled


def like(value, x):
    """`value` in the precision of the scalar `x`.

    A Python literal is a float64 and would turn a float32 law into a float64 one; ``like(0.5, x)`` does not.
    """
    return type(x)(value)


@overload(like, inline="always")
def _like(value, x):
    if isinstance(x, types.Float):
        precision = x
        return lambda value, x: precision(value)
    return None


def by_type(kernels):
    """A function that is, where it is called, the one of `kernels` (type of the first argument: kernel) its first argument asks for.

    The type is known when the caller is compiled, so that the caller holds the chosen kernel and no choice.  The kernels take the
    same arguments.
    """
    plain = {kind: getattr(chosen, "py_func", chosen) for kind, chosen in kernels.items()}

    def stage(*arguments):
        return plain[type(arguments[0])](*arguments)

    def choose(*arguments):
        return plain.get(getattr(arguments[0], "instance_class", None))

    choose.__signature__ = inspect.signature(next(iter(plain.values())))
    overload(stage, inline="always")(choose)
    return stage
