"""Runs inside YADE: `peer_yade` writes what it reads.  One rotation engine, told a new axis and speed in
every step, makes the nutation.
"""

import json
import math
import sys
import time

import numpy as np
from yade import (
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    ForceResetter,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    RotationEngine,
    ViscElMat,
    utils,
)

with open("given") as file:
    given = json.load(file)
particles = np.load("particles.npy")


def material(name, density):
    law = given[name]
    return O.materials.append(
        ViscElMat(
            density=density,
            kn=law["kn"],
            ks=law["ks"],
            cn=law["cn"],
            cs=0.0,
            frictionAngle=math.atan(law["friction"]),
            young=-1,
            poisson=-1,
        )
    )


grain, plate = material("sphere", given["density"]), material("plate", given["density"])
spheres = O.bodies.append(
    [utils.sphere(tuple(p[:3]), given["diameter"] / 2, material=grain) for p in particles]
)
for number, p in zip(spheres, particles, strict=True):
    O.bodies[number].state.vel = tuple(p[3:6])
    O.bodies[number].state.angVel = tuple(p[6:])
facets = O.bodies.append(
    [
        utils.facet([tuple(corner) for corner in triangle], material=plate)
        for triangle in np.load("triangles.npy")
    ]
)
turn = RotationEngine(
    ids=facets, rotationAxis=(0, 0, 1), angularVelocity=0, rotateAroundZero=True, zeroPoint=(0, 0, 0)
)
samples = []


def nutate():
    theta = given["angle"] + given["speed"] * (O.iter + 0.5) * given["substep"]
    s, c = math.sin(given["tilt"]), math.cos(given["tilt"])
    axis = np.array([s * math.cos(theta), s * math.sin(theta), 1 - c])
    size = float(np.linalg.norm(axis))
    turn.rotationAxis, turn.angularVelocity = tuple(axis / size), given["speed"] * size


def note():
    if O.iter >= given["before"]:
        axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        wrench = [utils.sumForces(facets, a) for a in axes] + [
            utils.sumTorques(facets, a, (0, 0, 0)) for a in axes
        ]
        samples.append([O.iter * given["substep"], *wrench])


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist=0.25 * given["diameter"]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
        [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
        [Law2_ScGeom_ViscElPhys_Basic()],
    ),
    PyRunner(command="nutate()", iterPeriod=1),
    turn,
    NewtonIntegrator(damping=0, gravity=(0, 0, -given["gravity"])),
]
if given["sample"]:
    O.engines = [*O.engines, PyRunner(command="note()", iterPeriod=given["sample"])]
O.dt = given["substep"]
O.run(given["before"], True)
seconds, seen, moments = 0.0, [], []
for _ in range(given["pieces"]):
    begun = time.perf_counter()
    O.run(given["steps"], True)
    seconds += time.perf_counter() - begun
    if given["sample"]:
        states = [O.bodies[number].state for number in spheres]
        seen.append([[*state.pos, *state.vel, *state.angVel] for state in states])
        moments.append(O.iter * given["substep"])
np.savez(
    "told.npz", seconds=seconds, samples=np.array(samples), seen=np.array(seen), moments=np.array(moments)
)
sys.stdout.flush()
O.pause()
