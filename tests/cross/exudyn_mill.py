"""A mill in Exudyn, body by body and joint by joint from the same descriptions, and its readings over time.

Gerstmayr, Multibody System Dynamics 60, 321-348, 2024 (Exudyn): index-3 constraints, generalized-alpha
method.
"""

import exudyn
import exudyn.itemInterface as items
import numpy as np
from exudyn.utilities import RigidBodyInertia

from nutamill.mechanism.parts import GROUND, JointKind
from nutamill.mechanism.rows import frame_along, matrix_of

HELD = {
    JointKind.FIXED: [1, 1, 1, 1, 1, 1],
    JointKind.REVOLUTE: [1, 1, 1, 1, 1, 0],
    JointKind.POINT_ON_LINE: [1, 1, 0, 0, 0, 0],
}
"""Constrained axes of a generic joint, in the joint's frame, third axis along the joint's."""


def exudyn_mill(mill, first, drive_angle, step, steps, every):
    """Integrate a mill from a state and read it every so many steps.

    Parameters
    ----------
    mill : bodies, joints, bushings and drives, by `mechanism_parts`
    first : position, quaternion, velocity, angular velocity of each body at the start, SI, world axes
    drive_angle : angle [rad] and speed [rad/s] of the driven joint at a time [s]
    step, steps, every : step [s], their number, steps between readings

    Returns
    -------
    readings : minus the force of each joint on its body b (n_rows, 3), in axes of its body a; "torque"
        (n_rows,) on the driven joint; position of each body ("body ..."), (n_rows, 3), world; "time"
        (n_rows,)
    """
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    number = {GROUND: system.CreateGround()}
    for k, body in enumerate(mill.bodies):
        number[body.name] = system.CreateRigidBody(
            inertia=RigidBodyInertia(body.mass, body.inertia, [0, 0, 0]),
            referencePosition=np.asarray(first[0][k], float),
            referenceRotationMatrix=matrix_of(first[1][k]),
            initialVelocity=list(first[2][k]),
            initialAngularVelocity=list(first[3][k]),
            gravity=[0.0, 0.0, -9.81],
        )
    as_built = {body.name: (np.asarray(body.position), matrix_of(body.quaternion)) for body in mill.bodies}
    as_built[GROUND] = np.zeros(3), np.eye(3)

    def marker(name, point, axes):
        """A marker at a world point as assembled, and the turn from the body's axes to `axes`."""
        place, attitude = as_built[name]
        local = attitude.T @ (np.asarray(point) - place)
        return system.AddMarker(
            items.MarkerBodyRigid(bodyNumber=number[name], localPosition=local.tolist())
        ), attitude.T @ axes

    driven, sensors, frames = mill.drives[0].joint, {}, {}
    for joint in mill.joints:
        axes = np.eye(3) if joint.axis is None else frame_along(joint.axis)
        one, turn_one = marker(joint.body_a, joint.point, axes)
        two, turn_two = marker(joint.body_b, joint.point, axes)
        held, moved, frames[joint.name] = HELD[joint.kind], {}, turn_one
        if joint.name == driven:
            held = [1] * 6
            moved["offsetUserFunction"] = lambda _system, t, _item, _parameters: [
                0,
                0,
                0,
                0,
                0,
                drive_angle(t)[0],
            ]
            moved["offsetUserFunction_t"] = lambda _system, t, _item, _parameters: [
                0,
                0,
                0,
                0,
                0,
                drive_angle(t)[1],
            ]
        built = system.AddObject(
            items.ObjectJointGeneric(
                markerNumbers=[one, two],
                constrainedAxes=held,
                rotationMarker0=turn_one,
                rotationMarker1=turn_two,
                **moved,
            )
        )
        kinds = {joint.name: exudyn.OutputVariableType.ForceLocal}
        if joint.name == driven:
            kinds["torque"] = exudyn.OutputVariableType.TorqueLocal
        for name, kind in kinds.items():
            sensors[name] = system.AddSensor(
                items.SensorObject(objectNumber=built, outputVariableType=kind, storeInternal=True)
            )
    for bushing in mill.bushings:
        axes = frame_along(bushing.axis)
        one, turn_one = marker(bushing.body_a, bushing.point, axes)
        two, turn_two = marker(bushing.body_b, bushing.point, axes)
        k, c = ([r[0], r[0], r[1], r[2], r[2], r[3]] for r in (bushing.stiffness, bushing.damping))
        system.AddObject(
            items.ObjectConnectorRigidBodySpringDamper(
                markerNumbers=[one, two],
                stiffness=np.diag(k),
                damping=np.diag(c),
                rotationMarker0=turn_one,
                rotationMarker1=turn_two,
            )
        )
    for body in mill.bodies:
        sensors[f"body {body.name}"] = system.AddSensor(
            items.SensorBody(
                bodyNumber=number[body.name],
                outputVariableType=exudyn.OutputVariableType.Position,
                storeInternal=True,
            )
        )
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = steps * step
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.5
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = True
    settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.newton.relativeTolerance = 1e-10
    settings.timeIntegration.newton.absoluteTolerance = 1e-10
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = every * step
    system.SolveDynamic(settings)
    stored = {name: system.GetSensorStoredData(sensor) for name, sensor in sensors.items()}
    time = next(iter(stored.values()))[:, 0]
    readings = {
        name: rows[:, 1:] @ frames[name].T if name in frames else rows[:, 1:] for name, rows in stored.items()
    }
    return readings | {"torque": stored["torque"][:, 3], "time": time}
