"""What a run takes is said beforehand, and warned of where it is too much."""

import pytest

from nutamill.base.host import free_disk, total_memory
from nutamill.case import load_case
from nutamill.design.forecast import Forecast
from nutamill.design.preflight import preflight
from nutamill.simulation.setup.threads import usable_cores

RIGID = "mechanism.mounting=rigid"
DAY = 86400.0


@pytest.mark.parametrize(
    ("wall_time", "memory", "file_size", "warned"),
    [
        (DAY, 4e9, 50e9, []),
        (DAY + 1.0, 4e9, 50e9, ["the run takes about 24.0 h, more than a day. Key T brings it down"]),
        (
            DAY,
            4.1e9,
            50e9,
            ["the memory takes about 4100 MB, more than half of the 8000 MB of memory. Key M brings it down"],
        ),
        (
            DAY,
            4e9,
            51e9,
            [
                "the file takes about 51 GB, more than half of the 100 GB free on the disk. Key F "
                "brings it down"
            ],
        ),
    ],
)
def test_more_than_a_day_or_half_of_the_memory_or_disk_is_warned_of(wall_time, memory, file_size, warned):
    forecast = Forecast(wall_time, memory, file_size, "Key T", "Key M", "Key F")
    assert [str(warning) for warning in forecast.warnings(8e9, 100e9)] == [
        f"forecast: {text}" for text in warned
    ]
    # a system that does not say what it has
    assert all("more than a day" in str(warning) for warning in forecast.warnings(None, None))


def test_the_sheet_warns_of_a_run_of_months_and_of_threads_that_are_not_there():
    cores = usable_cores()
    case = load_case(
        "numill",
        [
            RIGID,
            "charge.count=2000",
            "run.until=20000 s",
            f"run.threads={cores + 1}",
            "run.series_rate=10 Hz",
        ],
    )
    sheet = preflight(case)
    assert [warning.where for warning in sheet.warnings] == ["run.threads", "forecast"]
    lines = sheet.lines()
    assert lines[0].endswith(": ok, 2 warnings")
    assert f"asks for {cores + 1} threads on a machine with {cores} core" in lines[1]
    assert lines[2].endswith(
        "Coarser particles (charge.diameter), softer contacts or an earlier run.until brings it down"
    )


def test_a_small_run_on_the_cores_there_are_is_not_warned_of():
    case = load_case(
        "numill",
        [RIGID, "charge.count=20", "run.until=1 s", f"run.threads={usable_cores()}", "drive.ramp=7000 rpm/s"],
    )
    assert preflight(case).warnings == []


def test_the_machine_has_memory_and_room(tmp_path):
    assert total_memory() is None or total_memory() > 1e8
    # a folder that is still to be made is on the disk of the one it will be made in
    assert free_disk(tmp_path / "not" / "there" / "yet.h5") == pytest.approx(free_disk(tmp_path), rel=0.1)
