"""A steel ball dropped on a floor, and a box of balls poured on each other: particles without a mill.

Checked: each bounce reaches the restitution squared of the height before, and the floor of the box carries
the weight of the balls.
"""

import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

DIAMETER, DENSITY, DROP, RESTITUTION = 0.01, 7850.0, 0.05, 0.8
steel = nm.linear_pair(stiffness=1e5, restitution=RESTITUTION, friction=0.3, rolling_friction=0.02)
floor = nm.plane("floor")

ball = nm.spheres([DIAMETER]).placed([[0.0, 0.0, DIAMETER / 2 + DROP]])
charge = nm.Charge(ball, [DENSITY], steel, [floor], dt=1e-5)
heights = np.array([charge.march(2e-4).positions[0, 2] - DIAMETER / 2 for _ in range(2500)])
tops = heights[1:-1][(heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])]
contact = np.pi * np.sqrt(DENSITY * np.pi / 6 * DIAMETER**3 / 1e5)
for bounce, top in enumerate(tops[:3], start=1):
    expected = DROP * RESTITUTION ** (2 * bounce)
    print(f"bounce {bounce}: {1e3 * top:.2f} mm, closed form {1e3 * expected:.2f} mm")
    # the closed form leaves out gravity during each contact, a share g t/v of the speed at most
    assert abs(top / expected - 1) < 2 * bounce * 9.81 * contact / np.sqrt(2 * 9.81 * expected)

grid = 1.1 * DIAMETER * np.stack(np.meshgrid(*[np.arange(1.0, 5.0)] * 3), axis=-1).reshape(-1, 3)
sides = [nm.plane("left", [0, 0, 0], [1, 0, 0]), nm.plane("right", [0.06, 0, 0], [-1, 0, 0])]
sides += [nm.plane("front", [0, 0, 0], [0, 1, 0]), nm.plane("back", [0, 0.06, 0], [0, -1, 0])]
balls = nm.spheres([DIAMETER] * len(grid)).placed(grid)
box = nm.Charge(balls, [DENSITY], steel, [floor, *sides], dt=1e-5).march(1.0).march(0.1)
weight = 9.81 * DENSITY * np.pi / 6 * DIAMETER**3 * len(grid)
carried = -box.wrenches[0, 2]
print(f"{len(grid)} balls with {box.contacts[0]} contacts: the box carries {carried:.3f} of {weight:.3f} N")
assert abs(carried - weight) < 0.01 * weight
plt.plot(2e-4 * np.arange(1, 2501), 1e3 * heights)
plt.gca().set(xlabel="time (s)", ylabel="height (mm)")
plt.savefig("bouncing_ball.png")
