"""What a run reports while it goes on."""

from typing import NamedTuple

COMPILING = "compiling kernels, once for this version, some minutes"


class Progress(NamedTuple):
    """Where a run stands; numbers that are not known yet are NaN."""

    phase: str
    """``settle``, ``ramp`` or ``steady``."""
    time: float
    """Simulated time [s]."""
    end_time: float
    """Simulated time at which the run ends [s]."""
    fraction: float
    """Share of the phase that is done [1]."""
    rate: float
    """Simulated seconds per second of wall time [1]."""
    nanoseconds: float
    """Wall time per particle and charge substep [ns]."""
    time_left: float
    """Expected wall time to the end of the run [s]."""
    crank_pin_force: float
    """Present resultant at the load cell [N]."""
    shaft_torque: float
    """Present motor torque on the driveshaft [N m]."""
    mean_force: float
    """Mean crank-pin force over the whole turns at constant speed so far [N]."""
    mean_force_half_width: float
    """Half width of its 95 % interval [N]."""
    mean_torque: float
    """Mean torque over the same turns [N m]."""
    mean_torque_half_width: float
    """Half width of its 95 % interval [N m]."""
    largest_pair_overlap: float
    """Largest overlap of two particles lately, share of the particle diameter [1]."""
    largest_wall_overlap: float
    """Largest overlap of a particle with a surface lately, share of the particle diameter [1]."""
    ledger_residual: float
    """Residual of the energy ledger, share of the motor work [1]."""
    contacts: int
    """Particle contacts at present [1]."""
    dt: float
    """Charge substep [s]."""
    file_size: int
    """Size of the result file [bytes]."""
