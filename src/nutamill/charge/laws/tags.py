"""Names of the laws: each a type, so that a compiled loop holds the chosen laws and no choice."""

from typing import NamedTuple


class LinearSpring(NamedTuple):
    """Normal: linear spring and dashpot."""


class HystereticSpring(NamedTuple):
    """Normal: linear spring, stiffer on unloading; no dashpot."""


class HertzSpring(NamedTuple):
    """Normal: Hertz's spring, with the dashpot that gives a restitution independent of speed."""


class StoredDisplacement(NamedTuple):
    """Tangential: the contact remembers the length of its spring."""


class StoredForce(NamedTuple):
    """Tangential: the contact remembers the force of its spring, which grows by increments."""


class NoRolling(NamedTuple):
    """Rolling: no resistance."""


class RollingTypeA(NamedTuple):
    """Rolling: constant moment against the relative spin."""


class RollingTypeC(NamedTuple):
    """Rolling: spring on the relative rolling angle with a limit."""


class NoCohesion(NamedTuple):
    """Cohesion: none."""


class AreaCohesion(NamedTuple):
    """Cohesion: a pull in proportion to the contact area."""


NORMAL = {"linear": LinearSpring(), "hysteretic": HystereticSpring(), "hertz": HertzSpring()}
"""Normal laws by the names of case files."""

TANGENTIAL = {"displacement": StoredDisplacement(), "incremental": StoredForce()}
"""Tangential laws by the names of case files."""

ROLLING = {"none": NoRolling(), "type_a": RollingTypeA(), "type_c": RollingTypeC()}
"""Rolling laws by the names of case files."""

COHESION = {"none": NoCohesion(), "area": AreaCohesion()}
"""Cohesive laws by the names of case files."""


class ContactLaw(NamedTuple):
    """The law of all contacts of a charge, composed of four; its type is all it says."""

    normal: LinearSpring | HystereticSpring | HertzSpring = LinearSpring()
    """Force along the normal."""
    tangential: StoredDisplacement | StoredForce = StoredDisplacement()
    """Friction."""
    rolling: NoRolling | RollingTypeA | RollingTypeC = RollingTypeC()
    """Resistance to rolling."""
    cohesion: NoCohesion | AreaCohesion = NoCohesion()
    """Pull."""


STANDARD_LAW = ContactLaw()
"""Linear spring and dashpot, stored displacement, rolling type C, no cohesion."""


def contact_law(
    normal: str = "linear", tangential: str = "displacement", rolling: str = "type_c", cohesion: str = "none"
) -> ContactLaw:
    """The law that four names of `NORMAL`, `TANGENTIAL`, `ROLLING` and `COHESION` compose.

    Raises
    ------
    KeyError : a name that none of them has
    """
    return ContactLaw(NORMAL[normal], TANGENTIAL[tangential], ROLLING[rolling], COHESION[cohesion])


def law_names(law: ContactLaw) -> tuple[str, str, str, str]:
    """The four names of a law; the inverse of `contact_law`."""
    families = (NORMAL, TANGENTIAL, ROLLING, COHESION)
    return tuple(
        next(name for name, known in family.items() if type(known) is type(tag))
        for family, tag in zip(families, law, strict=True)
    )
