"""Which materials of a case touch: the one rule for the checks, the engine, the clock and the statistics."""

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from nutamill.case.charge_checks import AnyCase

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


def touching_pairs(case: "AnyCase") -> tuple[TouchingPair, ...]:
    """Return the pairs of the charge's own materials, then each of these with every wall.

    An empty chamber has none.
    """
    own, walls = case.charge.materials, dict.fromkeys(case.wall_materials.values())
    between = [TouchingPair(a, b, False) for number, a in enumerate(own) for b in own[number:]]
    return (*between, *(TouchingPair(a, wall, True) for a in own for wall in walls))
