"""Object code of kernels for programs without Python: a block that holds their arguments, and LLVM for them.

A block is a table of whole and real numbers (8 bytes each), then arrays.  Of an array the table has its place
in the block [bytes] and its shape, of a number the number itself, in the order of the arguments.  Compiled
code reads places and shapes from the table, so that it serves every block of the same types.
"""

import contextlib
import functools
import hashlib
import pickle
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from nutamill.base.cache_folder import cache_folder
from nutamill.base.compiled_files import CompiledFiles
from nutamill.base.kernel import kernel_digest

ALIGNMENT = 64
"""Places of arrays are multiples of this [bytes]."""
WORD = 8
"""Size of an entry of the table [bytes]."""


class CodeTarget(NamedTuple):
    """A platform that object code is for."""

    triple: str
    """LLVM's name of processor, system and binary format."""
    cpu: str
    """Processor whose instructions are used."""
    features: str = ""
    """Instructions beyond or without those of the processor, as LLVM writes them."""
    same_bits: bool = False
    """Whether the code is emitted as it was compiled for this processor, so that fast arithmetic rounds as in
    the running program; else it is optimised anew.
    """


def this_processor(triple: str) -> CodeTarget:
    """Return the target of code that has the bits of the running program, on the platform of `triple`."""
    import llvmlite.binding as llvm

    return CodeTarget(triple, llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), True)


class Block:
    """Arguments of kernels in one piece of memory.

    Parameters
    ----------
    arguments : by name: arrays, numbers, and named tuples of them
    last : names of arrays that are placed behind all others

    Attributes
    ----------
    places : place of each array in the block [bytes], by its dotted name
    entries : place of the entry of each array and number in the table [bytes], by its dotted name
    items : size of a number of each array [bytes], by its dotted name
    content : the block (n,), bytes
    """

    def __init__(self, arguments: dict[str, Any], last: Sequence[str] = ()):
        table: list[Any] = []
        self.entries: dict[str, int] = {}
        arrays: list[tuple[str, int, np.ndarray]] = []

        def lay(name: str, value: Any) -> None:
            self.entries[name] = WORD * len(table)
            if isinstance(value, np.ndarray):
                arrays.append((name, len(table), np.ascontiguousarray(value)))
                table.extend((0, *value.shape))
            elif isinstance(value, tuple):
                for field, inner in zip(value._fields, value, strict=True):  # type: ignore[attr-defined]
                    lay(f"{name}.{field}", inner)
            else:
                table.append(value)

        for name, value in arguments.items():
            lay(name, value)
        arrays.sort(key=lambda array: array[0] in last)
        self.items = {name: array.itemsize for name, _, array in arrays}
        end = _aligned(WORD * len(table))
        self.places: dict[str, int] = {}
        for name, entry, array in arrays:
            table[entry] = self.places[name] = end
            end = _aligned(end + array.nbytes)
        self.content = np.zeros(end, np.uint8)
        for k, number in enumerate(table):
            kind = np.float64 if isinstance(number, float) else np.int64
            self.content[WORD * k : WORD * (k + 1)] = np.array([number], kind).view(np.uint8)
        for name, _, array in arrays:
            place = self.places[name]
            self.content[place : place + array.nbytes] = np.frombuffer(array.tobytes(), np.uint8)


def _aligned(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT


class KernelEntry(NamedTuple):
    """A function of a library: a kernel whose arguments are in the block."""

    name: str
    """Its name in the library."""
    function: Callable
    """The kernel."""
    arguments: tuple[str, ...]
    """Names of its arguments in the block, "step" or "count" for numbers that the caller gives, or a whole
    number as text.
    """
    has_status: bool
    """Whether its result is a status, which becomes that of the entry; else the entry gives 0."""


CALLER_NUMBERS = ("step", "count")
"""Arguments that the caller of a library gives: a real and a whole number, in this order."""


def object_code(entries: Sequence[KernelEntry], arguments: dict[str, Any], target: CodeTarget) -> bytes:
    """Return object code with the entries for a platform, without a call of Python.

    Each entry is ``int name(int64_t *result, void **exception, void *block, ...)``, followed by the numbers
    that the caller gives, and returns 0.

    Parameters
    ----------
    entries : the functions
    arguments : their arguments by name, as the block has them
    target : the platform
    """
    kinds = repr([(name, str(_type_of(value))) for name, value in arguments.items()])
    named = repr([(entry.name, entry.function.__qualname__, entry.arguments) for entry in entries])
    whole = "\n".join([kernel_digest(), kinds, named, *map(str, target), _versions()])
    files = CompiledFiles(cache_folder(), "object_code")
    key = hashlib.sha256(whole.encode()).hexdigest()
    if isinstance(stored := files.load(key), bytes):
        return stored
    code = _emitted([_compiled(entry, arguments) for entry in entries], target)
    with contextlib.suppress(OSError):
        files.save(key, pickle.dumps(code))
    return code


def constant_object(name: str, content: bytes, target: CodeTarget) -> bytes:
    """Return object code with one constant array of bytes."""
    from llvmlite import ir

    module = ir.Module(name)
    kind = ir.ArrayType(ir.IntType(8), len(content))
    variable = ir.GlobalVariable(module, kind, name)
    variable.initializer = ir.Constant(kind, bytearray(content))
    variable.global_constant = True
    variable.align = ALIGNMENT
    machine, layout = _machine(target)
    import llvmlite.binding as llvm

    parsed = llvm.parse_assembly(_retargeted(str(module), target.triple, layout))
    return machine.emit_object(parsed)


def _versions() -> str:
    import llvmlite
    import numba

    return f"{numba.__version__} {llvmlite.__version__}"


def _type_of(value: Any) -> Any:
    import numba

    return numba.typeof(value)


def _compiled(entry: KernelEntry, arguments: dict[str, Any]) -> tuple[str, str, str]:
    """Return LLVM of an entry with all that it calls, the name of its function there, and its own name."""
    import numba
    from numba import types

    start, trees = 0, {}
    for name, value in arguments.items():
        trees[name], start = _tree(value, start)
    views = [_view(trees[name]) if name in trees else None for name in entry.arguments]
    given = [name for name in entry.arguments if name in CALLER_NUMBERS]
    pairs = enumerate(zip(entry.arguments, views, strict=True))
    texts = [name if view is None else f"view{k}(base)" for k, (name, view) in pairs]
    call = f"kernel({', '.join(texts)})"
    result = f"return {call}" if entry.has_status else f"{call}\n    return 0"
    source = f"def entry({', '.join(['base', *given])}):\n    {result}\n"
    space: dict[str, Any] = {"kernel": entry.function}
    space |= {f"view{k}": view for k, view in enumerate(views) if view is not None}
    exec(source, space)
    numbers = {"step": types.float64, "count": types.int64}
    signature = types.int64(types.voidptr, *(numbers[name] for name in given))
    compile_: Any = numba.cfunc  # its types leave out what it passes on
    compiled = compile_(signature, nopython=True, error_model="numpy", _nrt=False)(space["entry"])
    return compiled._library.get_llvm_str(), compiled.native_name.removeprefix("cfunc."), entry.name


def _tree(value: Any, start: int) -> tuple[Any, int]:
    """Return the type of an argument with the entries of the table it is made of, and the next entry."""
    kind = _type_of(value)
    if isinstance(value, np.ndarray):
        return (kind, start), start + 1 + value.ndim
    if isinstance(value, tuple):
        parts = []
        for inner in value:
            part, start = _tree(inner, start)
            parts.append(part)
        return (kind, parts), start
    return (kind, start), start + 1


def _view(tree: Any) -> Any:
    """Return what makes an argument of a kernel from the address of a block, in compiled code."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.extending import intrinsic
    from numba.np.arrayobj import make_array, populate_array

    word = ir.IntType(64)

    @intrinsic
    def view(typing_context, base):
        def code(context, builder, signature, args):
            table = builder.bitcast(args[0], word.as_pointer())

            def entry(k):
                return builder.load(builder.gep(table, [ir.Constant(word, k)]))

            def made(part):
                kind, where = part
                if isinstance(where, list):
                    return context.make_tuple(builder, kind, [made(inner) for inner in where])
                if not isinstance(kind, types.Array):
                    number = entry(where)
                    return number if kind == types.int64 else builder.bitcast(number, ir.DoubleType())
                array = make_array(kind)(context, builder)
                data = builder.bitcast(builder.gep(args[0], [entry(where)]), array.data.type)
                item = context.get_abi_sizeof(context.get_data_type(kind.dtype))
                shape = [entry(where + 1 + k) for k in range(kind.ndim)]
                strides: list[Any] = []
                size = ir.Constant(word, item)
                for length in reversed(shape):
                    strides.insert(0, size)
                    size = builder.mul(size, length)
                whole = context.get_value_type(types.intp)
                populate_array(
                    array,
                    data=data,
                    shape=cgutils.pack_array(builder, shape, ty=whole),
                    strides=cgutils.pack_array(builder, strides, ty=whole),
                    itemsize=ir.Constant(word, item),
                    meminfo=None,
                )
                return array._getvalue()

            return made(tree)

        return tree[0](types.voidptr), code

    return view


@functools.cache
def _machine(target: CodeTarget) -> tuple[Any, str]:
    """Return LLVM's machine of a target, and its data layout."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    family = llvm.Target.from_triple(target.triple)
    machine = family.create_target_machine(
        cpu=target.cpu, features=target.features, opt=3, reloc="pic", codemodel="default"
    )
    return machine, str(machine.target_data)


def _retargeted(text: str, triple: str, layout: str) -> str:
    """Return LLVM text with another target. A hint to a waiting x86 processor is left out elsewhere."""
    lines = [
        line
        for line in text.splitlines()
        if not line.startswith(("target datalayout", "target triple"))
        and (triple.startswith("x86_64") or "@llvm.x86.sse2.pause()" not in line)
    ]
    head = [f'target datalayout = "{layout}"', f'target triple = "{triple}"']
    return "\n".join([*lines[:1], *head, *lines[1:]])


def _emitted(compiled: Sequence[tuple[str, str, str]], target: CodeTarget) -> bytes:
    """Return one object with the entries. All other functions are internal, so that what none calls is left
    out, calls of Python among it.
    """
    import llvmlite.binding as llvm

    machine, layout = _machine(target)
    whole = None
    for text, inner, name in compiled:
        module = llvm.parse_assembly(_retargeted(text, target.triple, layout))
        for function in module.functions:
            if function.name == inner:
                function.name = name
                function.linkage = "external"
                function.visibility = "hidden"
            elif not function.is_declaration:
                function.linkage = "internal"
        for variable in module.global_variables:
            if not variable.is_declaration:
                variable.linkage = "internal"
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    assert whole is not None
    whole.verify()
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=3))
    if target.same_bits:
        passes = llvm.create_new_module_pass_manager()
        passes.add_global_dead_code_eliminate_pass()
    else:
        passes = builder.getModulePassManager()
    passes.run(whole, builder)
    return machine.emit_object(whole)
