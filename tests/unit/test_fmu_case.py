"""`[[fmus]]` in a case: what contradicts is refused with its line, before any FMU is looked at."""

import pytest
from motor_on_shaft import MOTOR, SHAFT

from nutamill.base.errors import CaseError
from nutamill.case import Machine, load_case

BODY = """
[[fmus.bodies]]
body     = "shaft"
position = ["px", "py", "pz"]
"""
SECOND = MOTOR.replace('"motor"', '"second"')


def case_of(folder, text):
    (folder / "motor.fmu").write_bytes(b"not looked at here")
    (folder / "shaft.toml").write_text(text, encoding="utf-8")
    return load_case(folder / "shaft.toml")


def test_a_case_with_an_fmu_is_known_by_the_content_of_the_fmu_and_not_by_its_place(tmp_path):
    first = case_of(tmp_path, SHAFT + MOTOR)
    (tmp_path / "elsewhere").mkdir()
    second = case_of(tmp_path / "elsewhere", SHAFT + MOTOR)
    assert first.digest == second.digest
    assert first.fmus[0].file != second.fmus[0].file
    assert Machine.from_toml(first.to_toml()) == first
    (tmp_path / "motor.fmu").write_bytes(b"another one")
    assert load_case(tmp_path / "shaft.toml").digest != first.digest


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SHAFT + MOTOR.replace('"shaft"', '"shift"'), 'no drive is called "shift". Did you mean "shaft"?'),
        (SHAFT + MOTOR.replace('"M"', '""'), 'must be the name of a variable of the FMU, got ""'),
        (
            SHAFT + MOTOR.partition("[[fmus.drives]]")[0],
            "has no use: it gives no torque, moves no body and feeds no other FMU",
        ),
        (
            SHAFT.replace("\n[run]", "motor = { torque = '1 N m' }\n\n[run]") + MOTOR,
            'the drive "shaft" has a motor of its own',
        ),
        (SHAFT + MOTOR + SECOND, 'the drive "shaft" gets its torque from two FMUs'),
        (SHAFT + MOTOR + MOTOR, 'is the name of two FMUs, got "motor"'),
        (
            SHAFT + MOTOR.replace("24.0", "nan"),
            "start.U: must be a finite number, true, false or text, got nan",
        ),
        (
            SHAFT + MOTOR.replace("24.0", "[1.0]"),
            "start.U: must be a finite number, true, false or text, got",
        ),
        (SHAFT + MOTOR + BODY, "fmus.motor.drives: belong to an FMU that also moves bodies"),
        (SHAFT + MOTOR.replace('torque = "M"', ""), "has no use: it gives no torque, moves no body and"),
        (SHAFT + MOTOR + BODY.replace('"shaft"', '"shift"'), 'no body is called "shift"'),
        (SHAFT + MOTOR + BODY + BODY, 'the body "shaft" is moved by two FMUs'),
        (SHAFT + MOTOR + BODY + SECOND + BODY, "a second FMU moves bodies"),
        (SHAFT + MOTOR + BODY, 'connects "shaft", which an FMU moves'),
        (
            SHAFT
            + MOTOR
            + BODY
            + '\n[[torques]]\nname="t"\nbody="shaft"\nmoment=["1 N m","0 N m","0 N m"]\n',
            'acts on "shaft", which an FMU moves',
        ),
        (
            SHAFT + MOTOR + BODY + 'attitude = ["a", "b", "c"]\n',
            "needs 4 names for quaternion, got 3",
        ),
        (
            SHAFT + MOTOR.replace("start = {", 'links = { U = "controller.y" }\nstart = {'),
            'no other FMU gives "controller.y"',
        ),
        (SHAFT.replace("[run]", '[run]\nstart = "rest"') + MOTOR + BODY, '"rest" cannot be computed'),
        (
            SHAFT.replace("[run]", '[run]\ncoupling = "iterated"') + MOTOR + BODY,
            '"iterated" is not made for a drive of an FMU beside bodies',
        ),
        (
            SHAFT
            + MOTOR
            + BODY
            + '\n[[bodies]]\nname="pan"\nmass="1 kg"\ninertia=["1 kg m^2","1 kg m^2","1 kg m^2"]\n'
            'position=["0 m","0 m","0 m"]\n[[walls]]\nname="floor"\nbody="pan"\nshape="plane"\n'
            'material="steel"\npoint=["0 m","0 m","0 m"]\naxis=[0,0,1]\n',
            'is on "pan", which the FMU does not move',
        ),
    ],
)
def test_what_contradicts_is_refused(tmp_path, text, message):
    with pytest.raises(CaseError) as error:
        case_of(tmp_path, text)
    assert message in str(error.value)


def test_a_drawn_mill_takes_a_motor_and_no_foreign_bodies(tmp_path):
    (tmp_path / "motor.fmu").write_bytes(b"not looked at here")
    mill = 'base = "numill"\n' + MOTOR.replace('drive  = "shaft"', 'drive  = "motor"')
    (tmp_path / "mill.toml").write_text(mill, encoding="utf-8")
    assert load_case(tmp_path / "mill.toml").machine.fmus[0].drives[0].torque == "M"
    (tmp_path / "mill.toml").write_text(mill + BODY.replace("shaft", "chamber"), encoding="utf-8")
    with pytest.raises(CaseError, match='no body is called "chamber"'):
        load_case(tmp_path / "mill.toml")
