"""The contacts of a machine and their laws, as the terms of other programs are taken of them."""

from dataclasses import dataclass

from nutamill.case.machine import Machine
from nutamill.charge.laws.composition import ContactLaw, law_files
from nutamill.charge.laws.terms import Terms, Touch
from nutamill.simulation.setup.charge import contact_law_of, pair_law, quickest_meeting


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact of two materials and its law."""

    law: ContactLaw
    """The law."""
    touch: Touch
    """Numbers and sizes."""

    def terms(self, program: str) -> tuple[Terms, ...]:
        """Return normal, tangential, rolling and cohesive law and film in the terms of a program."""
        return tuple(file.terms(self.touch)[program] for file in law_files(self.law))


def touches(machine: Machine) -> dict[str, Contact]:
    """Return the contacts of particles of a machine with each other and with walls, by the names of the two
    materials.
    """
    contact, law = machine.contact, contact_law_of(machine)
    normal, contacts = law_files(law)[0], {}
    for touching in machine.touching:
        first, second, wall = touching
        one, other = machine.materials[first], machine.materials[second]
        pair, met = pair_law(machine, first, second), quickest_meeting(machine, first, second, wall)
        contacts[touching.name] = Contact(
            law,
            Touch(
                pair=pair,
                wall=wall,
                mass=met.mass,
                diameters=(met.diameter, met.other_diameter),
                young=(contact.softening * one.young_modulus, contact.softening * other.young_modulus),
                poisson=(one.poisson_ratio, other.poisson_ratio),
                softening=0.0 if contact.stiffness == "direct" else contact.softening,
                stiffens=normal.STIFFENS,
                restitution=normal.restitution(pair),
            ),
        )
    return contacts


def missing_laws(terms: tuple[Terms, ...]) -> list[str]:
    """Return what a program lacks of a law, from its terms."""
    return [law.missing for law in terms if law.missing]


def granular_words(contact: Contact) -> str:
    """Return the law in the words of LAMMPS that follow ``pair_coeff i j`` or ``granular``. A part that
    LAMMPS lacks is left out (`missing_laws`).
    """
    normal, tangential, rolling, *_ = contact.terms("LAMMPS")
    words = f"{normal.words} tangential {tangential.words}{rolling.words}"
    return words + (" limit_damping" if contact.touch.pair.tension_cut else "")
