"""What a shared library asks of others and offers, for the binary formats of Linux, Windows and macOS."""

import re
from typing import NamedTuple

import lief

lief.logging.disable()  # it prints a line for each symbol that a stripped library has not


class Symbols(NamedTuple):
    """Symbols of a shared library, as C writes them."""

    asked: list[str]
    """Functions of other libraries."""
    offered: list[str]
    """Functions and data for others, without those of the format itself."""
    libraries: list[str]
    """Other libraries."""
    names: list[str]
    """Its own name, where the format has one."""
    glibc: str
    """Oldest GNU C library that has all that is asked for; empty elsewhere."""


def symbols(content: bytes) -> Symbols:
    """Return the symbols of a library."""
    binary = lief.parse(content)
    if isinstance(binary, lief.PE.Binary):
        asked = [entry.name for library in binary.imports for entry in library.entries]
        exports = binary.get_export()
        offered = [entry.name for entry in exports.entries]
        libraries = [library.name for library in binary.imports]
        return Symbols(sorted(asked), sorted(offered), libraries, [exports.name], "")
    asked = sorted({function.name for function in binary.imported_functions})
    offered = sorted({symbol.name for symbol in binary.exported_symbols if symbol.name})
    if isinstance(binary, lief.MachO.Binary):
        own = [one.name for one in binary.libraries if one.command == lief.MachO.LoadCommand.TYPE.ID_DYLIB]
        others = [one.name for one in binary.libraries if one.name not in own]
        plain = [name.removeprefix("_") for name in offered]
        offered = [name for name in plain if name not in ("__dso_handle", "_mh_dylib_header")]
        return Symbols([name.removeprefix("_") for name in asked], offered, others, own, "")
    versions = {str(symbol.symbol_version) for symbol in binary.imported_symbols}
    numbers = [tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_([\d.]+)", " ".join(versions))]
    return Symbols(asked, offered, list(binary.libraries), [], ".".join(map(str, max(numbers, default=()))))


def of_python(names: list[str]) -> list[str]:
    """Return those names that are Python's, or of Numba's runtime in Python."""
    return [name for name in names if re.match(r"_*(Py|NRT_|numba_(?!attempt_nocopy|frexp|ldexp))", name)]
