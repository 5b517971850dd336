"""Which materials of a case touch: the one rule for the checks, the engine, the clock and the statistics."""

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from nutamill.case.mill import Case

Key = tuple[str | int, ...]


class TouchingPair(NamedTuple):
    """Two materials whose surfaces can touch, the charge's first."""

    first: str
    """Material of a particle."""
    second: str
    """Material of the other particle, or of the wall."""
    wall: bool
    """Whether the second is a wall."""

    @property
    def name(self) -> str:
        """``steel-acrylic wall``, as tables and results name the pair."""
        return f"{self.first}-{self.second}{' wall' * self.wall}"


def wall_keys(case: "Case") -> dict[Key, str]:
    """Return the material of every wall that the charge can touch, by its key: chamber, ribs, then
    ``[[walls]]``.
    """
    materials: dict[Key, str] = {("chamber", "material"): case.chamber.material}
    if case.chamber.ribs and case.chamber.rib:
        materials[("chamber", "rib", "material")] = case.chamber.rib.material
    return materials | {
        ("walls", number, "material"): wall.material for number, wall in enumerate(case.walls)
    }


def touching_pairs(case: "Case") -> tuple[TouchingPair, ...]:
    """Return the pairs of the charge's own materials, then each of these with every wall; none for an empty
    chamber.
    """
    own, walls = case.charge.materials, dict.fromkeys(wall_keys(case).values())
    between = [TouchingPair(a, b, False) for number, a in enumerate(own) for b in own[number:]]
    return (*between, *(TouchingPair(a, wall, True) for a in own for wall in walls))
