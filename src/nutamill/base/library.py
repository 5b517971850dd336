"""Where files are: the machines of the package, and the sets of mounts, charges and shapes that come with the
package.
"""

import difflib
from pathlib import Path

LONGEST_WORD = 100
"""Characters of a word that are compared with the known ones [1]."""
LISTED = 12
"""Known words that a hint lists before it counts the rest [1]."""
FOLDER = Path(__file__).parents[1] / "data" / "machines"
MOUNTS = FOLDER / "mounts"
CHARGES = FOLDER / "charges"
SHAPES = FOLDER / "shapes"
ORES = FOLDER.parent / "ores"


def library_names() -> list[str]:
    """Return the names of the machines of the package, the newest of those with a year or a size at the end
    also without it.
    """
    stems = sorted(path.stem for path in FOLDER.glob("*.toml"))
    bare = {name for name, _, last in (stem.rpartition("-") for stem in stems) if last[:1].isdigit()}
    return sorted({*stems, *bare} - {""})


def library_file(name: str) -> Path | None:
    """Return the file of a machine of the package: ``numill-2025``, or ``numill`` for the newest of them."""
    if name not in library_names():
        return None
    exact = FOLDER / f"{name}.toml"
    return exact if exact.is_file() else max(FOLDER.glob(f"{name}-[0-9]*.toml"))


def mount_sets() -> list[str]:
    """Return the names of the published sets of mount properties."""
    return sorted(path.stem for path in MOUNTS.glob("*.toml"))


def charge_sets() -> list[str]:
    """Return the names of the published charges."""
    return sorted(path.stem for path in CHARGES.glob("*.toml"))


def shape_sets() -> list[str]:
    """Return the names of the sets of clump shapes."""
    return sorted(path.stem for path in SHAPES.glob("*.toml"))


def shape_file(name: str) -> Path | None:
    """Return the file of a set of clump shapes of the library."""
    return SHAPES / f"{name}.toml" if name in shape_sets() else None


def similar(word: str, known: list[str], cutoff: float = 0.5) -> str:
    """Return a hint that names the nearest of the known words, or the first of them."""
    if close := difflib.get_close_matches(word[:LONGEST_WORD], known, n=1, cutoff=cutoff):
        return f'Did you mean "{close[0]}"?'
    others = f" and {len(known) - LISTED} more" if len(known) > LISTED else ""
    return f"Known: {', '.join(known[:LISTED])}{others}" if known else ""


def ore_names() -> list[str]:
    """Return the names of the ores of the package."""
    return sorted(path.stem for path in ORES.glob("*.toml"))


def ore_file(name: str) -> Path | None:
    """Return the file of an ore of the library."""
    return ORES / f"{name}.toml" if name in ore_names() else None
