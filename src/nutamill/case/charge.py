"""What the charge consists of: one or more parts, each of spheres or clumps of one material, with their sizes
and their amount.
"""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from nutamill.base.errors import Fault
from nutamill.base.required import required
from nutamill.base.schema import AddedMass, Count, Length, Number, Positive, Share, Table, refusal
from nutamill.charge.particles.particles import LOOSE_PACKING
from nutamill.charge.particles.shapes import shape_faults
from nutamill.charge.particles.sizes import SizeClasses, SizeLaw, normal_sizes, rosin_rammler_sizes

SIZE_KEYS = ("diameter", "sizes", "distribution")
"""Keys of which a part has one: its sizes."""

AMOUNT_KEYS = ("mass", "count", "fill")
"""Keys of which a part has one: how much of it there is."""

LAW_KEYS = {"normal": ("mean", "deviation", "by"), "rosin_rammler": ("size", "exponent")}
"""Keys of a distribution, by its law, beside the two cuts."""


class Distribution(Table):
    """A law of sizes between two cuts; a clump counts with the diameter of the sphere of its volume."""

    law: Literal["normal", "rosin_rammler"]
    """Normal law of the diameter, or Rosin-Rammler law: the share exp(-(d/size)^exponent) of the mass is
    coarser than d.
    """
    mean: Length | None = None
    """Normal law: its mean before the cuts [m]."""
    deviation: Length | None = None
    """Normal law: its standard deviation before the cuts [m]."""
    by: Literal["number", "mass"] | None = None
    """Normal law: whether it gives shares of the number or of the mass; Rosin-Rammler always gives shares of
    the mass.
    """
    size: Length | None = None
    """Rosin-Rammler law: diameter that 1/e of the mass exceeds [m]."""
    exponent: Positive | None = None
    """Rosin-Rammler law: its uniformity [1]."""
    smallest: Length
    """Lower cut [m]; what is cut off is spread over the rest."""
    largest: Length
    """Upper cut [m]."""

    @model_validator(mode="after")
    def _of_its_law(self) -> "Distribution":
        for law, keys in LAW_KEYS.items():
            for key in keys:
                given = getattr(self, key) is not None
                if given and law != self.law:
                    raise refusal(
                        f'{key} does not belong to law = "{self.law}"',
                        f"Its keys: {', '.join(LAW_KEYS[self.law])}",
                    )
                if not given and law == self.law:
                    raise refusal(
                        f'{key} is missing, with law = "{self.law}"',
                        f"Its keys: {', '.join(LAW_KEYS[self.law])}",
                    )
        if self.smallest >= self.largest:
            raise refusal(
                f"smallest must be less than largest, got {self.smallest:g} m and {self.largest:g} m"
            )
        try:
            self.sizes()
        except ValueError as error:
            raise refusal(f"{error}", "Move smallest and largest") from None
        return self

    def sizes(self) -> SizeLaw:
        """Return the law as a distribution of sizes."""
        if self.law == "normal":
            return normal_sizes(
                required(self.mean), required(self.deviation), self.smallest, self.largest, required(self.by)
            )
        return rosin_rammler_sizes(required(self.size), required(self.exponent), self.smallest, self.largest)


class Shapes(Table):
    """Shapes of clumps; only their form counts, each is scaled to the sizes of the part."""

    source: str = ""
    """Name or file they were read from."""
    assumed: str = ""
    """Why these are no measured shapes, where they are not."""
    clumps: Annotated[tuple[tuple[tuple[Number, Number, Number, Number], ...], ...], Field(min_length=1)]
    """Each a list of spheres (x, y, z, radius) in any one unit of length [1]."""

    @model_validator(mode="after")
    def _rigid(self) -> "Shapes":
        for number, rows in enumerate(self.clumps):
            spheres = np.array(rows, float).reshape(-1, 4)
            if faults := shape_faults(spheres[:, :3], spheres[:, 3]):
                raise refusal(f"clump {number}, {faults[0].where}: {faults[0].what}", faults[0].hint)
        return self


def _shapes(given: Any) -> Any:
    """Return the table of shapes. A list of clumps alone stands for shapes without a source."""
    return {"clumps": given} if isinstance(given, (list, tuple)) else given


class Portion(Table):
    """Keys that one part of a charge has, and a charge of one part as well."""

    kind: str | None = None
    set: str | None = None
    """Name of a published charge in the library; keys beside it override it."""
    material: str | None = None
    """Their material."""
    shapes: Annotated[
        Shapes | None, BeforeValidator(_shapes), WithJsonSchema({"type": ["string", "array", "object"]})
    ] = None
    """Shapes of clumps, each equally often: a name in the library, a file, or a list of clumps of spheres (x,
    y, z, radius).
    """
    diameter: Length | None = None
    """Of all particles [m], of clumps that of the sphere of their volume; or give `sizes` or
    `distribution`.
    """
    sizes: tuple[tuple[Length, Share], ...] | None = None
    """Pairs of diameter [m] and share of the mass [1]; the shares sum to 1."""
    distribution: Distribution | None = None
    """A law of sizes."""
    mass: AddedMass | None = None
    """All particles together [kg]: the fewest, of each size, that weigh at least that; or give `count` or
    `fill`.
    """
    count: Annotated[Count, Field(gt=0)] | None = None
    """Number of particles [1]."""
    fill: Share | None = None
    """Share of the chamber's free volume that they take up as a settled bed of solids fraction `packing`
    [1].
    """
    region: str | None = None
    """The region that they are put into at the start; needed where a machine has several."""
    packing: Share = LOOSE_PACKING
    """Solids fraction of their bed [1]: turns `fill` into a volume of solid, and an amount into the volume of
    its bed.
    """

    def size_law(self) -> SizeClasses | SizeLaw:
        """Return the distribution from which the sizes of a number or a volume of particles are drawn."""
        return self.distribution.sizes() if self.distribution else SizeClasses(self._classes)

    @property
    def _classes(self) -> tuple[tuple[float, float], ...]:
        """Diameters [m] and their shares."""
        return self.sizes or ((required(self.diameter), 1.0),)

    @property
    def size_range(self) -> tuple[float, float]:
        """Smallest and largest diameter that may occur [m]."""
        if self.distribution:
            return self.distribution.smallest, self.distribution.largest
        diameters = [diameter for diameter, _ in self._classes]
        return min(diameters), max(diameters)

    def solid_volume(self, density: float, free_volume: float) -> float:
        """Return the volume of solid that the case asks for [m^3].

        A `count` asks for that many particles of mean volume.
        """
        if self.mass is not None:
            return self.mass / density
        if self.fill is not None:
            return self.fill * self.packing * free_volume
        return required(self.count) * self.size_law().mean_volume


class ChargePart(Portion):
    """One part of a charge of several: ``[[charge.part]]``."""

    kind: Literal["spheres", "clumps"]
    """Spheres, or rigid clumps of spheres."""


class ChargeRecipe(Portion):
    """The loose solids in the chamber: one part, whose keys stand here, or several, each a
    ``[[charge.part]]``.
    """

    kind: Literal["spheres", "clumps", "none"] | None = None
    """Spheres, rigid clumps of spheres, or an empty chamber."""
    part: tuple[ChargePart, ...] | None = None
    """Parts of a charge of several materials, instead of all other keys."""
    engine: Literal["lammps"] | None = None
    """Program that moves the particles: LAMMPS, on as many processes as ``mpiexec`` starts; else this one."""

    @property
    def parts(self) -> "tuple[ChargePart | ChargeRecipe, ...]":
        """Return the parts of the charge. An empty chamber has none."""
        return self.part or (() if self.kind in ("none", None) else (self,))

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials of the charge, each once."""
        return tuple(dict.fromkeys(required(part.material) for part in self.parts))


def portion_faults(part: Portion) -> list[tuple[str, str, str]]:
    """Return what contradicts or lacks within one part: key, what is wrong, hint."""
    findings = []
    for keys, example in ((SIZE_KEYS, 'diameter = "5 mm"'), (AMOUNT_KEYS, 'mass = "1 kg"')):
        given = [key for key in keys if getattr(part, key) is not None]
        if len(given) != 1:
            what = f"needs one of {', '.join(keys)}, got {' and '.join(given) if given else 'none'}"
            findings.append((given[-1] if given else keys[0], what, f"Write e.g. {example}"))
    if part.mass == 0.0:
        findings.append(("mass", "must be positive", 'For an empty chamber write kind = "none"'))
    if part.material is None:
        findings.append(("material", "is missing", "Name one of [materials.*]"))
    if part.kind == "clumps" and part.shapes is None:
        findings.append(("shapes", 'is missing, with kind = "clumps"', 'Write e.g. shapes = "coarse-sand"'))
    if part.kind == "spheres" and part.shapes is not None:
        findings.append(
            ("shapes", 'belongs to kind = "clumps", got kind = "spheres"', "Leave one of the two out")
        )
    if part.sizes is not None and abs((total := sum(share for _, share in part.sizes)) - 1.0) > 1e-6:
        findings.append(("sizes", f"the shares of the mass must sum to 1, got {total:g}", ""))
    return findings


def stand_ins(charge: ChargeRecipe) -> list[Fault]:
    """Return the shapes that are assumed and not measured."""
    key = "charge.part[{}].shapes" if charge.part else "charge.shapes"
    assumed = [
        (number, part.shapes)
        for number, part in enumerate(charge.parts)
        if part.shapes and part.shapes.assumed
    ]
    return [
        Fault(key.format(number), f'"{shapes.source}" is a stand-in: {shapes.assumed}')
        for number, shapes in assumed
    ]
