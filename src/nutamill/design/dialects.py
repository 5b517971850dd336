"""The contact laws of a case in the words of Rocky, PFC, LAMMPS and LIGGGHTS, so that numbers can be carried
over.

SI units.  Where a stiffness depends on the size of the particles it is that of those with the shortest
contacts.  A law that a program does not have is said to be missing; what it has but means otherwise stands
behind a ``#``.

Sources: Ansys Rocky, DEM Technical Manual 2024 R2; Itasca PFC documentation 6 to 9, contact models linear,
rrlinear, hertz; LAMMPS documentation, pair_style granular; LIGGGHTS-PUBLIC 3.8 documentation, gran models.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from nutamill.case import Case
from nutamill.charge.laws import hysteretic
from nutamill.charge.laws.composition import law_names
from nutamill.charge.laws.oscillator import restitution_from_damping_ratio
from nutamill.charge.laws.pair import PairLaw, spring_stiffness
from nutamill.simulation.setup.charge import Meeting, contact_law_of, pair_law, quickest_meeting


@dataclass(frozen=True, slots=True)
class Touch:
    """All that a dialect says a contact of two materials in."""

    names: tuple[str, str, str, str]
    """Normal, tangential, rolling and cohesive law, as `law_names`."""
    pair: PairLaw
    """Their numbers."""
    wall: bool
    """Whether the second is a wall."""
    met: Meeting
    """Sizes and masses."""
    young: tuple[float, float]
    """Young's modulus of the two as the law takes it, softened [Pa]."""
    poisson: tuple[float, float]
    """Poisson's ratio of the two [1]."""
    softening: float
    """Share of the solid's Young's modulus that the law takes [1]; 0 where stiffness is given directly."""

    @property
    def k(self) -> float:
        """Normal stiffness of a linear or hysteretic spring [N/m]."""
        return spring_stiffness(self.pair, self.met.diameter, self.met.other_diameter)

    @property
    def kt(self) -> float:
        """Its tangential stiffness [N/m]."""
        return self.pair.tangential_ratio * self.k

    @property
    def plain_restitution(self) -> float:
        """Restitution the dashpot would give with tension kept [1]: programs that take e work out the dashpot
        so.
        """
        return restitution_from_damping_ratio(self.pair.damping_ratio, False)

    @property
    def restitution(self) -> float:
        """Restitution without cohesion [1]."""
        if self.names[0] == "hysteretic":
            return hysteretic.restitution(self.pair)
        return restitution_from_damping_ratio(self.pair.damping_ratio, self.pair.tension_cut)


def rocky(touch: Touch) -> list[str]:
    """Entries of Rocky's physics and materials panels."""
    normal, tangential, rolling, cohesion = touch.names
    pair = touch.pair
    shown = {
        "linear": "Linear Spring Dashpot",
        "hysteretic": "Hysteretic Linear Spring",
        "hertz": "Hertzian Spring Dashpot",
    }
    model = {"type_a": "Type A: Constant", "type_c": "Type C: Linear Spring Rolling Limit", "none": "none"}
    friction = "Mindlin-Deresiewicz, or nearest" if normal == "hertz" else "Linear Spring Coulomb Limit"
    lines = [
        f"normal force {shown[normal]}; tangential force {friction}; rolling resistance model "
        f"{model[rolling]}"
    ]
    solid = " and ".join(f"{e / touch.softening:.6g}" for e in touch.young) if touch.softening else ""
    if touch.softening:
        lines.append(f"bulk Young's modulus {solid} Pa, numerical softening factor {touch.softening:g}")
    else:
        lines.append(f"no direct stiffness: contact stiffness multiplier so that k = {touch.k:.6g} N/m")
    lines.append(
        "restitution "
        f"{math.sqrt(1 / pair.unloading_ratio) if normal == 'hysteretic' else touch.restitution:.6g},"
        f" static friction {pair.static_friction:g}, dynamic friction {pair.dynamic_friction:g},"
        f" tangential stiffness ratio {pair.tangential_ratio:g}"
    )
    if rolling != "none":
        lines.append(
            f"rolling resistance {pair.rolling_friction:g}  # belongs to the particle, not to the pair"
        )
    if normal != "hertz" and tangential == "displacement":
        lines.append("# it remembers the tangential force, not the length: the same at constant stiffness")
    return [*lines, *_without(cohesion == "area", "area cohesion")]


def pfc(touch: Touch) -> list[str]:
    """A line of ``contact cmat``."""
    normal, _, rolling, cohesion = touch.names
    pair = touch.pair
    missing = _without(rolling == "type_a", "type A rolling") + _without(cohesion == "area", "area cohesion")
    if normal == "hysteretic":
        return [*_without(True, "hysteretic linear spring"), *missing]
    mode = f"dp_sratio 0 dp_mode {int(pair.tension_cut)} fric {pair.static_friction:g}"
    if normal == "hertz":
        # two equal solids: E* = G/(1 - nu), G* = G/(2 (2 - nu)), so that E*/G* = 2 (2 - nu)/(1 - nu)
        quotient = pair.contact_modulus / (pair.tangential_ratio * pair.contact_shear_modulus)
        nu = (quotient - 4.0) / (quotient - 2.0)
        shear = pair.contact_modulus * (1.0 - nu)
        ratio = math.sqrt(5.0 / 6.0) * pair.damping_ratio
        missing += _without(rolling == "type_c", "rolling with hertz")
        line = f"model hertz property hz_shear {shear:.6g} hz_poiss {nu:.6g} dp_nratio {ratio:.6g} {mode}"
        return [
            line,
            "# dp_nratio counts with the tangent stiffness; hz_* are those of two equal solids with "
            "the same E* and G*",
            *missing,
        ]
    rr = f" rr_fric {pair.rolling_friction:g}" if rolling == "type_c" else ""
    model = "rrlinear" if rr else "linear"
    line = (
        f"model {model} property kn {touch.k:.6g} ks {touch.kt:.6g} dp_nratio {pair.damping_ratio:.6g} "
        f"{mode}{rr}"
    )
    return [line, "# its friction is limited by the spring's part of the normal force alone", *missing]


def lammps(touch: Touch) -> list[str]:
    """The line of ``pair_coeff``, or what follows ``granular`` in ``fix wall/gran/region``."""
    normal, tangential, rolling, cohesion = touch.names
    pair = touch.pair
    missing = _without(rolling == "type_a", "type A rolling") + _without(cohesion == "area", "area cohesion")
    if normal == "hysteretic":
        return [*_without(True, "hysteretic linear spring"), *missing]
    if pair.damping_ratio >= 1.0:
        return ["missing: a dashpot above its critical value", *missing]
    e, mu = touch.plain_restitution, pair.static_friction
    if normal == "hertz":
        rule = "mindlin/force" if tangential == "incremental" else "mindlin"
        shear = 8.0 * pair.tangential_ratio * pair.contact_shear_modulus
        line = (
            f"hertz {4 / 3 * pair.contact_modulus:.6g} {e:.6g} damping coeff_restitution tangential "
            f"{rule} {shear:.6g} 0 {mu:g}"
        )
        missing += _without(rolling == "type_c", "a rolling spring that follows Mindlin's stiffness")
    else:
        line = (
            f"hooke {touch.k:.6g} {e:.6g} damping coeff_restitution tangential linear_history "
            f"{touch.kt:.6g} 0 {mu:g}"
        )
        if rolling == "type_c":
            line += f" rolling sds {touch.kt:.6g} 0 {pair.rolling_friction:g}"
    line += " limit_damping" if pair.tension_cut else ""
    return [f"{'granular' if touch.wall else 'pair_coeff i j'} {line}", *_other_restitution(touch), *missing]


def liggghts(touch: Touch) -> list[str]:
    """The style, and values (i, j) of ``fix property/global``."""
    normal, tangential, rolling, cohesion = touch.names
    pair = touch.pair
    if normal == "hysteretic":
        return _without(True, "hysteretic linear spring (hooke/hysteresis is another)")
    model = "hertz" if normal == "hertz" else "hooke/stiffness"
    roll = {"none": "", "type_a": " rolling_friction cdt", "type_c": " rolling_friction epsd2"}[rolling]
    pull = " cohesion sjkr2" if cohesion == "area" else ""
    limit = " limitForce on" if pair.tension_cut else ""
    lines = [f"gran model {model} tangential history{pull}{roll} tangential_damping off{limit}"]
    if normal == "hertz":
        moduli, ratios = (
            " ".join(f"{e:.6g}" for e in touch.young),
            " ".join(f"{nu:g}" for nu in touch.poisson),
        )
        lines.append(f"youngsModulus peratomtype {moduli}; poissonsRatio peratomtype {ratios}")
        lines.append(f"coefficientRestitution {touch.plain_restitution:.6g}")
        lines += _other_restitution(touch)
        if tangential == "incremental":
            lines.append("# it remembers the tangential length, not the force")
        if pair.tangential_ratio != 1.0:
            lines.append(
                f"# its tangential stiffness is Mindlin's, here {pair.tangential_ratio:g} times that"
            )
    else:
        gamma = 2.0 * pair.damping_ratio * math.sqrt(touch.k / touch.met.mass)
        lines.append(f"kn {touch.k:.6g}; kt {touch.kt:.6g}; gamman {gamma:.6g}; gammat 0")
    rolls = f"; coefficientRollingFriction {pair.rolling_friction:g}" if roll else ""
    lines.append(f"coefficientFriction {pair.static_friction:g}{rolls}")
    if pull:
        # its wall has half the area: 2 pi d R
        lines.append(f"cohesionEnergyDensity {(2.0 if touch.wall else 1.0) * pair.cohesive_pressure:.6g}")
    return lines


DIALECTS: dict[str, Callable[[Touch], list[str]]] = {
    "Rocky": rocky,
    "PFC": pfc,
    "LAMMPS": lammps,
    "LIGGGHTS": liggghts,
}
"""Programs, and how each says a contact."""


def _without(asked: bool, what: str) -> list[str]:
    return [f"missing: {what}"] if asked else []


def _other_restitution(touch: Touch) -> list[str]:
    """Why the restitution written is not that of the case."""
    if not touch.pair.tension_cut or touch.pair.damping_ratio == 0.0:
        return []
    return [
        f"# {touch.plain_restitution:.6g} gives the dashpot of this case; with tension cut the "
        f"restitution is {touch.restitution:.6g}"
    ]


def touches(case: Case) -> dict[str, Touch]:
    """Contacts of the particles of a case with each other and with walls, by the names of the two
    materials.
    """
    contact, found = case.contact, {}
    for touching in case.touching:
        own, other, wall = touching
        both = case.materials[own], case.materials[other]
        found[touching.name] = Touch(
            names=law_names(contact_law_of(case)),
            pair=pair_law(case, own, other),
            wall=wall,
            met=quickest_meeting(case, own, other, wall),
            young=tuple(contact.softening * solid.young_modulus for solid in both),
            poisson=tuple(solid.poisson_ratio for solid in both),
            softening=0.0 if contact.stiffness == "direct" else contact.softening,
        )
    return found


def dialect_lines(case: Case) -> list[str]:
    """The contact laws of a case in all dialects, as text; SI units."""
    lines = []
    for name, touch in touches(case).items():
        laws, sizes = " x ".join(touch.names), dict.fromkeys((touch.met.diameter, touch.met.other_diameter))
        lines.append(
            f"{name}: {laws}; spheres of {' and '.join(f'{1e3 * size:.4g}' for size in sizes)} mm; SI units"
        )
        for program, say in DIALECTS.items():
            said = say(touch)
            lines += [f"  {program if k == 0 else '':9} {text}" for k, text in enumerate(said)]
    return lines
