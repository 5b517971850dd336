"""The contact laws of a case in the terms of Rocky, PFC, LAMMPS and LIGGGHTS, so that numbers can be carried
over.

SI units.  Where a stiffness depends on the size of the particles it is that of those with the shortest
contacts.  A law that a program does not have is listed as missing; where a program means something else, a
note stands behind a ``#``.  What a law is called in each program stands in the file of the law
(`nutamill.charge.laws`); here the lines of a program are put together.
"""

from collections.abc import Callable

from nutamill.base.units import in_unit
from nutamill.case import Machine
from nutamill.charge.laws.composition import law_names
from nutamill.charge.laws.terms import PROGRAMS, Terms
from nutamill.simulation.setup.touches import Contact, granular_words, missing_laws, touches


def _missing(terms: tuple[Terms, ...]) -> list[str]:
    """Return what the program lacks, a line for each law."""
    return [f"missing: {missing}" for missing in missing_laws(terms)]


def rocky(contact: Contact) -> list[str]:
    """Return the entries of Rocky's physics and materials panels."""
    touch, pair, terms = contact.touch, contact.touch.pair, contact.terms("Rocky")
    normal, tangential, rolling, *_ = terms
    lines = [f"normal force {normal.words}; rolling resistance model {rolling.words}"]
    if touch.softening:
        solid = " and ".join(f"{e / touch.softening:.6g}" for e in touch.young)
        lines.append(f"bulk Young's modulus {solid} Pa, numerical softening factor {touch.softening:g}")
    else:
        lines.append(f"no direct stiffness: contact stiffness multiplier so that k = {touch.k:.6g} N/m")
    lines.append(
        f"{normal.lines[0]}, static friction {pair.static_friction:g}, "
        f"dynamic friction {pair.dynamic_friction:g}, tangential stiffness ratio {pair.tangential_ratio:g}"
    )
    return [*lines, *rolling.lines, *tangential.notes, *_missing(terms)]


def pfc(contact: Contact) -> list[str]:
    """Return a line of ``contact cmat``."""
    pair, terms = contact.touch.pair, contact.terms("PFC")
    normal, tangential, rolling, *_ = terms
    if normal.missing:
        return _missing(terms)
    mode = f"{tangential.words} dp_mode {int(pair.tension_cut)} fric {pair.static_friction:g}"
    # the models with rolling resistance are called rr...
    line = f"model {'rr' if rolling.words else ''}{normal.words} {mode}{rolling.words}"
    return [line, *normal.notes, *_missing(terms)]


def lammps(contact: Contact) -> list[str]:
    """Return the line of ``pair_coeff``, or what follows ``granular`` in ``fix wall/gran/region``."""
    normal, tangential, *_ = terms = contact.terms("LAMMPS")
    if normal.missing or tangential.missing:
        return _missing(terms)
    style = "granular" if contact.touch.wall else "pair_coeff i j"
    return [f"{style} {granular_words(contact)}", *normal.notes, *_missing(terms)]


def liggghts(contact: Contact) -> list[str]:
    """Return the style, and values (i, j) of ``fix property/global``."""
    pair, terms = contact.touch.pair, contact.terms("LIGGGHTS")
    normal, tangential, rolling, cohesion, _ = terms
    if normal.missing:
        return _missing(terms)
    limit = " limitForce on" if pair.tension_cut else ""
    return [
        f"gran model {normal.words} tangential history{cohesion.words}{rolling.words} "
        f"{tangential.words}{limit}",
        *normal.lines,
        *normal.notes,
        *tangential.notes,
        "; ".join([f"coefficientFriction {pair.static_friction:g}", *rolling.lines]),
        *cohesion.lines,
        *_missing(terms),
    ]


DIALECTS: dict[str, Callable[[Contact], list[str]]] = dict(
    zip(PROGRAMS, (rocky, pfc, lammps, liggghts), strict=True)
)
"""Programs, and how each writes a contact."""


def dialect_lines(machine: Machine) -> list[str]:
    """Format the contact laws of a case in the terms of all programs, SI units."""
    lines = []
    for name, contact in touches(machine).items():
        laws, sizes = " x ".join(law_names(contact.law)), dict.fromkeys(contact.touch.diameters)
        spheres = " and ".join(f"{in_unit(size, 'mm'):.4g}" for size in sizes)
        lines.append(f"{name}: {laws}; spheres of {spheres} mm; SI units")
        for program, written in DIALECTS.items():
            lines += [f"  {program if k == 0 else '':9} {text}" for k, text in enumerate(written(contact))]
    return lines
