"""Rows of the work space of the vector loops, `ChargeScratch.columns`: which row holds what.  A vector takes
three.
"""

DISTANCE = 0
"""Pairs: from the first particle to the second [fixed-point units] (3)."""
REACH = 3
"""Pairs: sum of the two radii [fixed-point units]."""
NORMAL = 0
"""Walls: normal [1] (3)."""
OVERLAP = 3
"""Walls: overlap [m]."""
A = 4
"""First of the eight rows of the first particle, as `ChargeState.rows`; of the only one at a wall."""
V_A, MASS_A, W_A, RADIUS_A = A, A + 3, A + 4, A + 7
"""Velocity [m/s] (3), mass [kg], spin [rad/s] (3), radius [m] of the first particle."""
FORCE_A, MOMENT_A = A, A + 4
"""Force [N] (3) and moment [N m] (3) on the first particle, after the law."""
B = 12
"""First of the eight rows of the second particle of a pair."""
V_B, MASS_B, W_B, RADIUS_B = B, B + 3, B + 4, B + 7
FORCE_B, MOMENT_B = B, B + 4
ARM = 12
"""Walls: particle's centre from the body's mass centre [m] (3), world axes; after the law the angular impulse
rate on the body [N m] (3).
"""
ACT = 15
"""Walls: powers of the normal, tangential and rolling part of each lane [W] (3), after the law."""
MEMORY = 20
"""First of the eight rows of the contact memory, as `ChargeState.memory`."""
SPRING, ROLLED, STAMP, HISTORY = MEMORY, MEMORY + 3, MEMORY + 6, MEMORY + 7
LAW = 28
"""First of the thirteen rows with the numbers of the pair law, as `LawColumn`."""
WEIGHT = 41
"""1: counted here; 1/2: a pair across chunks, which the other chunk counts too; 0: unused lane [1]."""
PEAK = 42
"""Largest overlap so far in this lane over the diameter of the smaller particle: half of it [m], and the
radius [m] in `PEAK_RADIUS`.
"""
HELD = 43
"""Which pair law the lane's numbers are of [1]."""
BODY_V = 44
"""Walls: velocity of the body's mass centre [m/s] (3)."""
BODY_W = 47
"""Walls: spin of the body [rad/s] (3)."""
BODY = 50
"""Walls: number of the body, that of no body in an unused lane [1]."""
PEAK_RADIUS = 52
LIQUID = 53
"""First of the three rows with the numbers of the film, as `viscous_film.numbers`; of a wet charge."""
FILM_POWER = 56
"""Power of film and bridge on the relative motion [W], after the law; of a wet charge."""
BRIDGE = 57
"""First of the four rows with the numbers of the bridge, as `capillary.numbers`; with bridges only."""
PARTING = 61
"""Overlap of a contact that opens, minus the overlap of one that closes [m], after the law; 0 where nothing
touches.
"""
ROWS = 62
"""Rows of `columns` [1]."""
