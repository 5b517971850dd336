"""The registry of the contact laws, and the whole law of solids that touch: normal, tangential, rolling,
cohesion.

A law is one file of this folder and one entry of its family here.  Each file has

* `LAW`, an instance of an empty named tuple whose type stands for the law in compiled code;
* its kernels: ``force`` and ``energy`` of a normal or tangential law, ``moment`` and ``energy`` of a rolling
  law, ``pull`` of cohesion.  All laws of a family take the same arguments and return the same values;
* of a normal law also its ``numbers``, ``tangential_ratio``, ``impact``, ``resolve_time``, ``restitution``
  and ``STIFFENS``, and for its work of loading the kernels ``loading``, ``turned`` and ``to_book``;
* of a film its ``numbers``, ``reach``, force and the gaps it acts over (`meeting` joins it to the solids);
* ``faults``: what a pair lacks for the law;
* ``terms``: the law in the terms of other programs.
"""

from types import ModuleType
from typing import NamedTuple

from nutamill.base.frames import dot3, scale3, sub3
from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws import (
    area,
    capillary,
    displacement,
    hertz,
    hysteretic,
    incremental,
    incremental_dashpot,
    linear,
    no_cohesion,
    no_film,
    no_rolling,
    type_a,
    type_c,
    type_c_direct,
    viscous_film,
)
from nutamill.charge.laws.pair import NORMAL_NUMBERS, PairLaw
from nutamill.charge.laws.spring import LEAST_LENGTH

NORMAL = {"linear": linear, "hysteretic": hysteretic, "hertz": hertz}
"""Normal laws by the names of case files."""

TANGENTIAL = {
    "displacement": displacement,
    "incremental": incremental,
    "incremental_dashpot": incremental_dashpot,
}
"""Tangential laws by the names of case files."""

ROLLING = {"none": no_rolling, "type_a": type_a, "type_c": type_c, "type_c_direct": type_c_direct}
"""Rolling laws by the names of case files."""

COHESION = {"none": no_cohesion, "area": area}
"""Cohesive laws by the names of case files."""

FILM = {"none": no_film, "viscous": viscous_film, "capillary": capillary}
"""Films of liquid by the names of case files."""

FAMILIES = (NORMAL, TANGENTIAL, ROLLING, COHESION, FILM)
"""The families of laws, in the order of `ContactLaw`."""

normal_force = by_type({type(file.LAW): file.force for file in NORMAL.values()})
"""Normal force, stiffness and history of the law whose tag comes first; as `linear.force`."""

normal_energy = by_type({type(file.LAW): file.energy for file in NORMAL.values()})
"""Energy stored along the normal by the law whose tag comes first, and the stiffness; as `linear.energy`."""

loading_work = by_type({type(file.LAW): file.loading for file in NORMAL.values()})
"""Work of loading, and force, of the law whose tag comes first; as `linear.loading`."""

loading_turned = by_type({type(file.LAW): file.turned for file in NORMAL.values()})
"""Whether work of loading is to be booked under the law whose tag comes first; as `deepest.turned`."""

loading_to_book = by_type({type(file.LAW): file.to_book for file in NORMAL.values()})
"""What of it is to be booked under the law whose tag comes first; as `deepest.to_book`."""

friction_force = by_type({type(file.LAW): file.force for file in TANGENTIAL.values()})
"""Friction of the law whose tag comes first; as `displacement.force`."""

friction_energy = by_type({type(file.LAW): file.energy for file in TANGENTIAL.values()})
"""Energy in the tangential spring of the law whose tag comes first; as `displacement.energy`."""

rolling_moment = by_type({type(file.LAW): file.moment for file in ROLLING.values()})
"""Moment against rolling of the law whose tag comes first; as `type_c.moment`."""

rolling_energy = by_type({type(file.LAW): file.energy for file in ROLLING.values()})
"""Energy in the rolling spring of the law whose tag comes first; as `type_c.energy`."""

cohesive_pull = by_type({type(file.LAW): file.pull for file in COHESION.values()})
"""Pull of the law whose tag comes first; as `area.pull`."""


class ContactLaw(NamedTuple):
    """The law of all contacts of a charge, composed of five; only its type counts."""

    normal: tuple = linear.LAW
    """Force along the normal: the `LAW` of one of `NORMAL`."""
    tangential: tuple = displacement.LAW
    """Friction: of one of `TANGENTIAL`."""
    rolling: tuple = type_c.LAW
    """Resistance to rolling: of one of `ROLLING`."""
    cohesion: tuple = no_cohesion.LAW
    """Pull: of one of `COHESION`."""
    film: tuple = no_film.LAW
    """Liquid: of one of `FILM`."""


STANDARD_LAW = ContactLaw()
"""Linear spring and dashpot, stored displacement, rolling type C, no cohesion, no liquid."""


def contact_law(
    normal: str = "linear",
    tangential: str = "displacement",
    rolling: str = "type_c",
    cohesion: str = "none",
    film: str = "none",
) -> ContactLaw:
    """Return the law that five names of `NORMAL`, `TANGENTIAL`, `ROLLING`, `COHESION` and `FILM` compose.

    Raises
    ------
    KeyError : a name that none of them has
    """
    names = normal, tangential, rolling, cohesion, film
    return ContactLaw(*(family[name].LAW for family, name in zip(FAMILIES, names, strict=True)))


def law_names(law: ContactLaw) -> tuple[str, ...]:
    """Return the names of a law, one of each of `FAMILIES`, the inverse of `contact_law`."""
    return tuple(
        next(name for name, file in family.items() if type(file.LAW) is type(tag))
        for family, tag in zip(FAMILIES, law, strict=True)
    )


def law_files(law: ContactLaw) -> tuple[ModuleType, ...]:
    """Return the files of a law, in the order of `ContactLaw`."""
    return tuple(family[name] for family, name in zip(FAMILIES, law_names(law), strict=True))


def film_numbers(law: ContactLaw, pair: PairLaw) -> list[float]:
    """Return the numbers of a pair that the film of a charge reads. A dry charge has none."""
    return law_files(law)[4].numbers(pair)


def film_gap(law: ContactLaw, pair: PairLaw, radius: float) -> float:
    """Return the largest gap across which the film of a charge acts [m] between particles of at least
    `radius` [m].
    """
    return law_files(law)[4].reach(pair, radius)


def law_numbers(law: ContactLaw, pair: PairLaw) -> list[float]:
    """Return the numbers of a pair that the laws of a charge read, in the order of `LawColumn`."""
    normal = law_files(law)[0]
    numbers = normal.numbers(pair)
    return [
        *numbers,
        *[0.0] * (NORMAL_NUMBERS - len(numbers)),
        normal.tangential_ratio(pair),
        pair.static_friction,
        pair.dynamic_friction,
        pair.rolling_friction,
        1.0 / pair.overlap_stop,
        pair.cohesive_pressure,
        2.0 * pair.tangential_damping,
        pair.rolling_stiffness,
    ]


def law_faults(law: ContactLaw, pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair lacks for the laws of a charge, and what to write instead."""
    return [fault for file in law_files(law) for fault in file.faults(pair)]


@kernel(inline="always")
def contact(law, n, overlap, u, w, spring, rolled, sliding, history, m_eff, r_eff, diameters, numbers, dt):
    """Return the force and moment of one contact on the first body, its new memory and its powers.

    Parameters
    ----------
    law : `ContactLaw`
    n : normal [1] (3); overlap : [m]
    u : relative velocity at the contact point [m/s] (3); w : relative spin [rad/s] (3)
    spring, rolled, sliding, history : contact memory, see `displacement.force`, `type_c.moment` and
        `hysteretic.force`
    m_eff, r_eff : reduced mass [kg] and radius [m]; diameters : of the two [m] (2)
    numbers : of the pair, as `LawColumn` (13); dt : substep [s]

    Returns
    -------
    force [N] (3), its tangential part [N] (3), moment [N m] (3), spring (3), rolled [rad] (3), sliding [1],
    history, power of normal, tangential and rolling part on the relative motion [W] (3)
    """
    ratio, static, dynamic, rolling, _, pressure, twice_damping, stiffness = numbers[NORMAL_NUMBERS:]
    v_n = dot3(u, n)
    u = sub3(u, scale3(v_n, n))
    push, k, history = normal_force(
        law.normal, numbers[:NORMAL_NUMBERS], overlap, v_n, history, m_eff, r_eff, diameters, dt
    )
    load = push if push > like(0.0, dt) else like(0.0, dt)
    push -= cohesive_pull(law.cohesion, overlap, r_eff, pressure)
    kt = ratio * k
    friction, spring, sliding = friction_force(
        law.tangential, (static, dynamic, twice_damping), spring, sliding, u, n, kt, m_eff, load,
        like(LEAST_LENGTH, dt) * r_eff, dt,
    )  # fmt: skip
    moment, rolled = rolling_moment(
        law.rolling, rolled, w, n, kt, m_eff, r_eff, stiffness, rolling * r_eff * load, dt
    )
    powers = -push * v_n, dot3(friction, u), dot3(moment, w)
    return sub3(friction, scale3(push, n)), friction, moment, spring, rolled, sliding, history, powers


@kernel
def stored_energy(law, numbers, memory, last, overlap, radius_a, radius_b, r_eff):
    """Return the energy one contact would give back [J] (3): normal with cohesion, tangential, rolling.

    A tangential spring whose stiffness changes with the overlap changes its energy with it, without work:
    what it seems to lose or gain is booked as dissipated.

    Parameters
    ----------
    law : `ContactLaw`
    numbers : of the pair, as `LawColumn`
    memory : of the contact, as `ChargeState.memory`; counts only if its stamp is `last`
    overlap, radius_a, radius_b, r_eff : [m]; a wall takes the particle's radius for both, and for r_eff
    """
    alive = 1.0 if abs(memory[6]) == last else 0.0
    history = alive * float(memory[7])
    p = float(numbers[0]), float(numbers[1]), float(numbers[2]), float(numbers[3]), float(numbers[4])
    ratio, pressure = float(numbers[5]), float(numbers[10])
    normal, k = normal_energy(law.normal, p, overlap, history, r_eff, (2.0 * radius_a, 2.0 * radius_b))
    normal -= 0.5 * overlap * cohesive_pull(law.cohesion, overlap, r_eff, pressure)
    kt = k * ratio
    spring, rolled = 0.0, 0.0
    for e in range(3):
        spring += float(memory[e]) * float(memory[e])
        rolled += float(memory[3 + e]) * float(memory[3 + e])
    return (
        normal,
        friction_energy(law.tangential, alive * spring, kt),
        rolling_energy(law.rolling, alive * rolled, kt, r_eff, float(numbers[12])),
    )
