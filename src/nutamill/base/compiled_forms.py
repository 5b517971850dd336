"""Compile a kernel into two forms: one that Python calls, and one that becomes a part of other kernels.

Numba makes one form for both: machine code, and a wrapper that takes arguments from Python apart.  Most
kernels are called by other kernels only, which hold machine code of copies of their own.  So a part is typed,
lowered and optimised, but has no machine code and no wrapper.

The machine code of the form that Python calls is complete in itself.  Numba would leave copies of all that a
kernel calls beside it under public names, and the copy that was loaded first is the one that all kernels run:
fast-math copies differ in their last bits, so that results would depend on what else a process has compiled
or loaded before (`tests/contracts/test_same_bits.py`).

Both forms are stored in `CompiledFiles`.

Checked with Numba 0.61 to 0.68: private to Numba are `_index_key`, `_impl` and `_cache_path` of its
`FunctionCache`, `_finalize_final_module`, `_shared_module` and `_finalized` of its `JITCodeLibrary`, and
`_FunctionCompiler`.
"""

import contextlib
from collections.abc import Callable
from typing import Any, NamedTuple

from llvmlite.binding import Linkage, parse_assembly, parse_bitcode
from numba.core import typing
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]  # private
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps

from nutamill.base.cache_folder import cache_folder
from nutamill.base.compiled_files import CompiledFiles


class _CalledLibrary(JITCodeLibrary):
    """Machine code of a kernel that Python calls, with its own copies of other kernels."""

    def _finalize_final_module(self):
        public = []
        for function in self._final_module.functions:
            if function.is_declaration:
                continue
            if function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.internal
            elif function.linkage == Linkage.external:
                public.append(function.name)
        # No kernel is linked with this one. Numba takes the public names from here when it loads the code.
        self._shared_module = parse_assembly(
            "\n".join(f'define void @"{name}"() {{ ret void }}' for name in public)
        )
        super()._finalize_final_module()


class _PartLibrary(JITCodeLibrary):
    """LLVM code of a kernel for the kernels that call it, without machine code."""

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = Linkage.linkonce_odr
        self._shared_module = self._final_module
        self._finalized = True


class _CalledCompiler(Compiler):
    """Numba's compiler of a function, into a `_CalledLibrary`."""

    def define_pipelines(self):
        self.state.library = _CalledLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class _PartCompiler(Compiler):
    """Numba's compiler of a function, into a `_PartLibrary`."""

    def define_pipelines(self):
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.flags.no_cpython_wrapper = True
        self.state.flags.no_compile = True
        return super().define_pipelines()


class _Part(NamedTuple):
    """A kernel for some types of arguments, as a part of other kernels."""

    signature: Any
    """Numba's types of its arguments and its result."""
    description: Any
    """Numba's description of the function: its name in the library among other things."""
    library: _PartLibrary
    """Its code, with that of all it calls."""


class _CalledFormat(CompileResultCacheImpl):
    """How Numba turns a function that Python calls into something to store, and back."""

    def __init__(self):
        pass


class _PartFormat(CompileResultCacheImpl):
    """How a part is turned into something to store, and back."""

    def __init__(self):
        pass

    def check_cachable(self, part):
        return not part.library.has_dynamic_globals

    def reduce(self, part):
        part.description.typemap = part.description.calltypes = None  # large, and for compiling only
        return part.signature, part.description, part.library.name, part.library._final_module.as_bitcode()

    def rebuild(self, target_context, stored):
        signature, description, name, code = stored
        library = _PartLibrary(target_context.codegen(), name)
        library._final_module = parse_bitcode(code)
        library._finalize_final_module()
        return _Part(signature, description, library)


class _FormCache(FunctionCache):
    """One form of a kernel in `CompiledFiles`. What cannot be loaded or stored is compiled.

    Parameters
    ----------
    function : the kernel in Python
    form : how it is stored
    source : returns what differs between states of the sources, a part of the key
    """

    def __init__(self, function: Callable, form: CompileResultCacheImpl, source: Callable[[], tuple]):
        self._py_func = function
        self._impl = form
        self._cache_path = str(cache_folder())
        self._cache_file = CompiledFiles(  # type: ignore[assignment]  # it has the methods of Numba's class
            cache_folder(), f"{function.__module__}.{function.__qualname__}"
        )
        self._source = source
        self.enable()

    def _index_key(self, sig, codegen):
        return (*super()._index_key(sig, codegen), type(self._impl).__name__, self._source())

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
                codegen = data.library.codegen
                self._cache_file.save(self._index_key(sig, codegen), dumps(self._impl.reduce(data)))


class Kernel(CPUDispatcher):
    """A compiled function in both forms.

    Parameters
    ----------
    function : in Python
    options : of Numba's ``njit``
    source : returns what differs between states of the sources; what another state was compiled to is not
        used
    """

    def __init__(self, function: Callable, options: dict[str, Any], source: Callable[[], tuple]):
        options = {"nopython": True, "boundscheck": None, **options}
        super().__init__(function, targetoptions=options, pipeline_class=_CalledCompiler)
        self._cache = _FormCache(function, _CalledFormat(), source)
        self._part_cache = _FormCache(function, _PartFormat(), source)
        self._part_compiler = _FunctionCompiler(function, self.targetdescr, options, {}, _PartCompiler)
        self._parts: dict[tuple, _Part] = {}

    def get_call_template(self, args, kws):
        """Return what types a call by another kernel, and the types of its arguments."""
        pysig, args = self._part_compiler.fold_argument_types(args, kws)
        self._compile_part(tuple(args))
        name = self.py_func.__name__
        signatures = [part.signature for part in self._parts.values()]
        return typing.make_concrete_template(name, key=name, signatures=signatures), pysig, args, {}

    def get_overload(self, sig):
        """Return what stands for the code that another kernel calls with these types."""
        return self._parts[tuple(sig)].description

    def compile_for_kernels(self, *arguments: Any) -> None:
        """Compile the part for arguments like these, so that kernels which call it find it in the cache."""
        self._compile_part(tuple(self.typeof_pyval(argument) for argument in arguments))

    @global_compiler_lock
    def _compile_part(self, args: tuple) -> None:
        if args in self._parts:
            return
        part = self._part_cache.load_overload(args, self.targetctx)
        if part is None:
            compiled = self._part_compiler.compile(args, None)
            part = _Part(compiled.signature, compiled.fndesc, compiled.library)
            part.library.finalize()
            self._part_cache.save_overload(args, part)
        self.targetctx.insert_user_function(part.description, part.description, [part.library])
        self._parts[args] = part
