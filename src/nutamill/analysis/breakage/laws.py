"""Laws of the breakage of a single particle: whether it breaks, how weak it is left, how fine it becomes.

All take numbers or arrays.  Energies are specific ones: energy that loads a particle over its mass [J/kg].
"""

import numpy as np
from scipy.special import ndtr, ndtri

HALVINGS = 60
"""Halvings of the interval in which the damage is sought [1]: beyond the last bit of a number."""

Numbers = np.ndarray | float


def breakage_probability(energy: Numbers, least_energy: Numbers, weakness: Numbers) -> np.ndarray:
    """Return the probability [1] that a particle breaks: ``1 - exp(-weakness (energy - least_energy))``, 0
    below the least energy.

    Independent loadings multiply the probabilities of survival, so that `energy - least_energy` adds up.

    Parameters
    ----------
    energy : of the loading [J/kg]
    least_energy : below which nothing happens [J/kg]
    weakness : material parameter times size [kg/J]

    Source
    ------
    L. Vogel and W. Peukert, Powder Technology 129 (2003) 101-110; in the form of Ansys Rocky, DEM Technical
    Manual, "Ab-T10 breakage model"
    """
    return -np.expm1(-weakness * np.maximum(energy - least_energy, 0.0))


def fineness_of_impact(most: float, energy: Numbers, least_energy: Numbers, weakness: Numbers) -> np.ndarray:
    """Return ``t10`` [1], the share of the fragments finer than a tenth of the particle: ``most (1 -
    exp(-weakness (energy - least_energy)))``.

    Without a least energy it is ``t10 = A (1 - exp(-b Ecs))`` of the drop-weight test.

    Source: F. Shi and T. Kojovic, Int. J. Miner. Process. 82 (2007) 156-163.
    """
    return most * breakage_probability(energy, least_energy, weakness)


def median_fracture_energy(size: Numbers, coarse: float, half_size: float, exponent: float) -> np.ndarray:
    """Return the median specific fracture energy of particles of a `size` [m]: ``coarse (1 +
    (half_size/size)^exponent)`` [J/kg].

    Parameters
    ----------
    coarse : of large particles [J/kg]
    half_size : size of particles that are twice as strong [m]

    Source: L. M. Tavares and R. P. King, Int. J. Miner. Process. 54 (1998) 1-28.
    """
    return coarse * (1.0 + (half_size / np.asarray(size, float)) ** exponent)


def fracture_share(energy: Numbers, median: Numbers, spread: float, largest: float) -> np.ndarray:
    """Return the share of particles [1] whose specific fracture energy is less than `energy`: a lognormal
    law, cut off above.

    The lognormal variable is ``e largest/(largest - e)`` with e the energy over the median, so that no
    particle is stronger than `largest` times the median.

    Parameters
    ----------
    energy, median : specific energies [J/kg]
    spread : standard deviation of the logarithm [1]
    largest : strongest particle over the median [1]

    Source
    ------
    L. M. Tavares and R. P. King, Int. J. Miner. Process. 54 (1998) 1-28; cut as in ESSS, "Particle breakage
    models", Rocky DEM white paper
    """
    e = np.asarray(energy, float) / median
    with np.errstate(divide="ignore"):
        inside = np.log(np.where(e < largest, e * largest / np.maximum(largest - e, 1e-300), np.inf))
    return ndtr(inside / spread)


def fracture_energy_at(share: Numbers, median: Numbers, spread: float, largest: float) -> np.ndarray:
    """Return the specific fracture energy [J/kg] below which that of a `share` [1] of the particles is, the
    inverse of `fracture_share`.
    """
    e = np.exp(spread * ndtri(np.asarray(share, float)))
    return median * e / (1.0 + e / largest)


def damage(ratio: Numbers, exponent: float) -> np.ndarray:
    """Return the share of its stiffness [1] that a particle loses in a loading that does not break it.

    The force follows ``K (1 - D) x^(3/2)`` with ``D = (x/x_c)^exponent``; the particle breaks at D = 1.  From
    the works up to x and up to x_c,

        ``D = [2 g/(2 g - 5 D + 5) ratio]^(2 g/5)``, g the exponent.

    Parameters
    ----------
    ratio : energy of the loading over the fracture energy [1]; 1 or more breaks the particle
    exponent : damage accumulation coefficient of the material [1]

    Source
    ------
    L. M. Tavares and R. P. King, Powder Technology 123 (2002) 138-146: continuum damage of a Hertzian
    contact
    """
    ratio = np.minimum(np.asarray(ratio, float), 1.0)
    low, high = np.zeros_like(ratio), np.ones_like(ratio)
    power = 5.0 / (2.0 * exponent)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        below = middle**power * (1.0 + (1.0 - middle) * power) < ratio
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.where(ratio < 1.0, 0.5 * (low + high), 1.0)


def weakened(fracture_energy: Numbers, lost: Numbers) -> np.ndarray:
    """Return the fracture energy after a loading that did not break the particle: ``(1 - lost)`` times that
    before, in its unit. Source as for `damage`.
    """
    return np.asarray(fracture_energy) * (1.0 - np.asarray(lost))


def fineness_of_fracture(
    most: float, steepness: float, energy: Numbers, broken_median: Numbers
) -> np.ndarray:
    """Return ``t10`` [1] of particles that broke: ``most (1 - exp(-steepness energy/broken_median))``.

    Parameters
    ----------
    broken_median : median specific fracture energy of those that broke [J/kg]

    Source: ESSS, "Particle breakage models", Rocky DEM white paper (Tavares breakage model).
    """
    return -most * np.expm1(-steepness * np.asarray(energy) / broken_median)


def finer_share(t10: Numbers, reduction: Numbers, exponent: float) -> np.ndarray:
    """Return the share of the fragments ``t_n`` [1] that is finer than 1/n of the particle: ``1 - (1 -
    t10)^((9/(n - 1))^exponent)``.

    A Rosin-Rammler law in ``1/(n - 1)``, which is 0 for dust, t10 at n = 10, and 1 at the size of the
    particle.

    Parameters
    ----------
    t10 : share finer than a tenth [1], less than 1
    reduction : n [1]; at 1 and less everything is finer
    exponent : of the law, from the ore's measured sizes [1]

    Source
    ------
    R. P. King, "Modeling and Simulation of Mineral Processing Systems", Butterworth-Heinemann 2001, chapter 5
    (truncated Rosin-Rammler distribution)
    """
    n = np.asarray(reduction, float)
    power = (9.0 / np.where(n > 1.0, n - 1.0, 1.0)) ** exponent
    return np.where(n > 1.0, -np.expm1(np.log1p(-np.asarray(t10, float)) * power), 1.0)
