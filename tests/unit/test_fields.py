"""The registry of recorded quantities."""

import pytest

from nutamill.base.errors import CaseError
from nutamill.base.wrench import WRENCH
from nutamill.mechanism import sensors
from nutamill.result.fields import SERIES, SNAPSHOT, expand, series_field, snapshot_field
from nutamill.simulation import row


def test_every_name_of_a_mill_has_unit_symbol_and_meaning():
    names = expand(mounts=4, sensors=("frame_corner",))
    assert names[0] == "time"
    assert len(set(names)) == len(names)
    for name in names:
        field = series_field(name)
        assert field.name == name
        assert all((field.unit, field.symbol, field.label, field.meaning))
        assert not any(
            "{mount}" in text or "{sensor}" in text for text in (field.label, field.meaning, field.point)
        )


def test_part_of_the_machine_is_filled_in_where_people_read():
    assert series_field("mount_2_force_x").label == "mount 2 force, x"
    assert series_field("drive_end_acceleration_z").label == "drive end acceleration, z"


def test_machine_without_mounts_has_no_mount_series():
    assert not [name for name in expand(mounts=0) if name.startswith("mount_")]


@pytest.mark.parametrize(
    ("wrong", "right"),
    [("crankpin_force_radial", "crank_pin_force_radial"), ("mount_0_force_x", "mount_._force_x")],
)
def test_unknown_name_is_refused_with_the_nearest_one(wrong, right):
    with pytest.raises(CaseError, match=right):
        series_field(wrong)


def test_unknown_snapshot_array_is_refused():
    with pytest.raises(CaseError, match="positions"):
        snapshot_field("position")


def test_every_component_names_its_axes():
    for field in SERIES + SNAPSHOT:
        if field.name.endswith(("_x", "_y", "_z", "_radial", "_tangential")):
            assert field.frame, field.name


def test_sensors_and_rows_name_the_components_of_a_wrench_as_the_series_do():
    assert sensors.FORCE_COLUMNS == row.WRENCH == WRENCH
