"""Recorded quantities of the parts of any mechanism, by the names its file gives them."""

from nutamill.result.fields.field import WORLD, Field, energy, vector

AXES_A = "axes of the bushing, fixed in its body a"
SENSOR_AXES = "world, or axes of the body the sensor names"


def _wrench(name: str, label: str, meaning: str, frame: str, point: str) -> tuple[Field, ...]:
    """Declare force and moment about the same point, three components each."""
    force = vector(f"{name}_force", "F", "N", f"{label} force", f"force {meaning}", frame, point)
    return force + vector(
        f"{name}_moment", "M", "N m", f"{label} moment", f"moment {meaning}", frame, f"about the {point}"
    )


PART_SERIES: tuple[Field, ...] = (
    *_wrench(
        "joint_{joint}",
        "{joint}",
        "joint {joint} exerts on its body b, friction included",
        WORLD,
        "joint's point on b",
    ),
    *_wrench(
        "bushing_{bushing}",
        "{bushing}",
        "bushing {bushing} exerts on its body b",
        AXES_A,
        "bushing's point on b",
    ),
    *vector(
        "bushing_{bushing}_travel",
        "u",
        "m",
        "{bushing} travel",
        "displacement of b relative to a at {bushing}",
        AXES_A,
        "",
    ),
    *vector(
        "bushing_{bushing}_turn",
        "r",
        "rad",
        "{bushing} turn",
        "rotation vector of b relative to a",
        AXES_A,
        "",
    ),
    Field(
        "drive_{drive}_angle",
        "\\theta",
        "rad",
        "{drive} angle",
        "angle drive {drive} has turned its joint, not wrapped",
    ),
    Field("drive_{drive}_speed", "\\Omega", "rad/s", "{drive} speed", "speed of drive {drive}"),
    Field(
        "drive_{drive}_torque",
        "T",
        "N m",
        "{drive} torque",
        "torque of drive {drive} on its joint's body b, about the axis",
    ),
    Field(
        "linear_drive_{drive}_travel",
        "s",
        "m",
        "{drive} travel",
        "travel of linear drive {drive} along its joint's axis",
    ),
    Field("linear_drive_{drive}_speed", "v", "m/s", "{drive} speed", "speed of linear drive {drive}"),
    Field(
        "linear_drive_{drive}_force",
        "F",
        "N",
        "{drive} force",
        "force of linear drive {drive} on its joint's body b, along the axis",
    ),
    Field(
        "gear_{gear}_torque",
        "T",
        "N m",
        "{gear} torque",
        "torque of gear {gear} on body b of its output, about the output's axis",
    ),
    Field(
        "stop_{stop}_force", "F", "N", "{stop} force", "force with which stop {stop} pushes its bodies apart"
    ),
    Field(
        "stop_{stop}_gap",
        "g",
        "m",
        "{stop} gap",
        "distance between the surfaces of stop {stop}, negative where they overlap",
    ),
    Field("{sensor}_spring_length", "l", "m", "{sensor} length", "length of the spring of sensor {sensor}"),
    Field(
        "{sensor}_spring_force",
        "F",
        "N",
        "{sensor} tension",
        "tension of the spring of sensor {sensor} and its damper, negative if it pushes",
    ),
    *vector(
        "{sensor}_position",
        "p",
        "m",
        "{sensor} position",
        "place of the point of sensor {sensor}",
        WORLD,
        "from the world's origin",
    ),
    *vector(
        "{sensor}_velocity",
        "v",
        "m/s",
        "{sensor} velocity",
        "velocity of the point of sensor {sensor}",
        SENSOR_AXES,
        "{sensor}",
    ),
    *(
        Field(
            f"{{sensor}}_attitude_{part}",
            f"q_{part}",
            "1",
            f"{{sensor}} attitude, {part}",
            f"component {part} of the quaternion",
            WORLD,
        )
        for part in "wxyz"
    ),
    *_wrench(
        "{sensor}_reaction",
        "{sensor}",
        "the joint of sensor {sensor} exerts on its body b",
        SENSOR_AXES,
        "joint's point on b",
    ),
    *_wrench(
        "{carrier}_charge",
        "charge on {carrier}",
        "of the charge on {carrier}, mean since the sample before",
        WORLD,
        "recorded point of {carrier}",
    ),
    energy("drive_{drive}_work", "W", "{drive}", "work drive {drive} has done so far"),
    energy("linear_drive_{drive}_work", "W", "{drive}", "work linear drive {drive} has done so far"),
    energy("fmu_{fmu}_work", "W", "{fmu}", "work the machine of FMU {fmu} has done on the charge so far"),
    energy("force_{force}_work", "W", "{force}", "work the given force {force} has done so far"),
    energy("stop_{stop}_loss", "D", "{stop}", "energy dissipated so far in stop {stop}"),
    energy("torque_{torque}_work", "W", "{torque}", "work the constant moment {torque} has done so far"),
    energy("joint_{joint}_loss", "D", "{joint}", "energy dissipated so far by friction in joint {joint}"),
    energy("bushing_{bushing}_loss", "D", "{bushing}", "energy dissipated so far in bushing {bushing}"),
    energy("spring_{spring}_loss", "D", "{spring}", "energy dissipated so far in spring {spring}"),
)
"""All series of the parts, in the order in which they stand in files and tables."""
