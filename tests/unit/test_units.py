"""The door for units: what goes in, what is refused, and with which words."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nutamill.base import units
from nutamill.base.units import Kind


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("700 rpm", Kind.SPEED, 700 * 2 * math.pi / 60),
        ("11.7 rev/s", Kind.SPEED, 11.7 * 2 * math.pi),
        ("70 rpm/s", Kind.RAMP, 70 * 2 * math.pi / 60),
        ("6 deg", Kind.ANGLE, 6 * math.pi / 180),
        ("366 mm", Kind.LENGTH, 0.366),
        ("72.2 N/mm", Kind.STIFFNESS, 72200.0),
        ("287 N m/rad", Kind.ROTATIONAL_STIFFNESS, 287.0),
        ("5.01 N m/deg", Kind.ROTATIONAL_STIFFNESS, 5.01 * 180 / math.pi),
        ("0.5 N m s/deg", Kind.ROTATIONAL_DAMPING, 0.5 * 180 / math.pi),
        ("34 N s/m", Kind.DAMPING, 34.0),
        ("0.03 N m s/rad", Kind.ROTATIONAL_DAMPING, 0.03),
        ("7863.7 kg/m^3", Kind.DENSITY, 7863.7),
        ("0.373 kg m^2", Kind.INERTIA, 0.373),
        ("200 GPa", Kind.PRESSURE, 200e9),
        ("9.81 m/s^2", Kind.ACCELERATION, 9.81),
        ("-12 mm", Kind.LENGTH, -0.012),
    ],
)
def test_text_with_a_unit_is_read_as_si(text, kind, si):
    assert units.parse(text, kind) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize("text", ["5 N·m", "5Nm", "5 N*m", " 5  N  m "])
def test_a_torque_may_be_spelled_as_engineers_do(text):
    assert units.parse(text, Kind.TORQUE) == 5.0


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("700", Kind.SPEED, 'needs a unit: write "700 rpm" (a plain number is ambiguous)'),
        ("5 kg", Kind.LENGTH, '"5 kg" is a mass, this needs a length, e.g. "5 mm"'),
        ("9 J", Kind.TORQUE, '"9 J" is an energy, this needs a torque, e.g. "5 N m"'),
        ("3 sec", Kind.TIME, 'unknown unit "sec". Did you mean "s"?'),
        ("3 RPM", Kind.SPEED, 'unknown unit "RPM". Did you mean "rpm"?'),
        (
            "12 hz",
            Kind.SPEED,
            '"12 hz" is a frequency; write "12 rev/s" or "720 rpm" (we do not guess between Hz and rad/s)',
        ),
        ("5 KG", Kind.LENGTH, '"5 KG" is a mass, this needs a length, e.g. "5 mm"'),
        ("3 furlong", Kind.MASS, 'unknown unit "furlong". Units of a mass: kg, g, mg, t, lb; e.g. "5 kg"'),
        (
            "11.7 Hz",
            Kind.SPEED,
            '"11.7 Hz" is a frequency; write "11.7 rev/s" or "702 rpm" (we do not guess between Hz '
            "and rad/s)",
        ),
        ("3,5 mm", Kind.LENGTH, '"3,5 mm" has a decimal comma. Write "3.5 mm"'),
        ("nan mm", Kind.LENGTH, 'must be a finite number with a unit, got "nan mm". Write e.g. "5 mm"'),
        ("1e999 mm", Kind.LENGTH, 'must be a finite number, got "1e999 mm"'),
        ("", Kind.LENGTH, 'must be a finite number with a unit, got "". Write e.g. "5 mm"'),
    ],
)
def test_what_is_no_quantity_of_the_kind_is_refused_in_these_words(text, kind, message):
    with pytest.raises(units.UnitError) as refused:
        units.parse(text, kind)
    assert str(refused.value) == message


@pytest.mark.parametrize("kind", Kind)
def test_the_example_of_each_kind_is_of_that_kind(kind):
    assert units.parse(units.example(kind), kind) > 0


def test_a_unit_belongs_to_one_kind():
    names = [unit for table in units.UNITS.values() for unit in table]
    assert len(names) == len(set(names))


@given(kind=st.sampled_from(Kind), value=st.floats(allow_nan=False, allow_infinity=False))
def test_a_written_value_is_read_back_to_the_same_float(kind, value):
    assert units.parse(units.format(value, kind), kind) == value


@given(text=st.text(max_size=20), kind=st.sampled_from(Kind))
def test_any_text_is_either_a_finite_number_or_refused_politely(text, kind):
    try:
        value = units.parse(text, kind)
    except units.UnitError as refused:
        assert refused.what
    else:
        assert math.isfinite(value)


@given(
    number=st.floats(1e-6, 1e6), given_kind=st.sampled_from(Kind), asked=st.sampled_from(Kind), data=st.data()
)
def test_a_unit_of_another_kind_is_never_taken(number, given_kind, asked, data):
    unit = data.draw(st.sampled_from(sorted(units.UNITS[given_kind])))
    text = f"{number!r} {unit}"
    if given_kind is asked:
        assert units.parse(text, asked) == pytest.approx(number * units.UNITS[asked][unit], rel=1e-15)
    else:
        with pytest.raises(units.UnitError, match=f"is an? {given_kind}"):
            units.parse(text, asked)


@pytest.mark.parametrize(
    ("value", "kind", "text"),
    [
        (0.366, Kind.LENGTH, "366 mm"),
        (0.0, Kind.TORQUE, "0 N m"),
        (3.6e-6, Kind.TIME, "3.6 us"),
        (2e11, Kind.PRESSURE, "200 GPa"),
    ],
)
def test_a_value_is_written_as_engineers_type_it(value, kind, text):
    assert units.format(value, kind) == text


def test_a_value_without_end_cannot_be_written():
    with pytest.raises(ValueError, match="not finite"):
        units.format(math.inf, Kind.MASS)


@pytest.mark.parametrize(
    ("value", "unit", "form", "text"),
    [
        (2.5e-6, "us", ".3g", "2.5 us"),
        (0.14, "mm", ".4g", "140 mm"),
        (math.pi / 30.0, "deg", ".2f", "6.00 deg"),
        (72200.0, "kN/m", "7.4g", "   72.2 kN/m"),
        (1.6e-3, "kg mm", ".4g", "1.6 kg mm"),
    ],
)
def test_a_quantity_is_shown_rounded_in_its_unit(value, unit, form, text):
    assert units.shown(value, unit, form) == text


@pytest.mark.parametrize("unit", [unit for table in units.UNITS.values() for unit in table])
def test_a_number_of_a_unit_is_the_si_value_that_its_text_has(unit):
    kind = next(kind for kind, table in units.UNITS.items() if unit in table)
    value = units.si_value(2.5, unit)
    assert value == pytest.approx(units.parse(f"2.5 {unit}", kind), rel=1e-15)
    assert units.in_unit(value, unit) == pytest.approx(2.5, rel=1e-15)
