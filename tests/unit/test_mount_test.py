"""Mount properties from a hysteresis loop: a spring with loss must come back, and what is no such test is
refused.
"""

import math

import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.mount_test import MountTest, mount_properties, read_mount_test
from nutamill.base.errors import CaseError

STIFFNESS, DAMPING, FREQUENCY, AMPLITUDE = 72.2e3, 34.0, 7.88, 2e-3


def moved_mount(rate=1000.0, seconds=2.0, noise=0.0, cubic=0.0, preload=150.0):
    """A Kelvin-Voigt mount moved as a sine: force = k x + c v + cubic x^3 + preload."""
    time = np.arange(round(rate * seconds)) / rate
    phase = 2.0 * math.pi * FREQUENCY * time + 0.3
    moved, speed = AMPLITUDE * np.sin(phase), AMPLITUDE * 2.0 * math.pi * FREQUENCY * np.cos(phase)
    force = STIFFNESS * moved + DAMPING * speed + cubic * moved**3 + preload
    return MountTest(
        time, moved + 0.5e-3, force + noise * np.random.default_rng(1).standard_normal(len(time))
    )


def test_spring_and_dashpot_come_back_exactly():
    properties = mount_properties(moved_mount())
    loss = 2.0 * math.pi * FREQUENCY * DAMPING
    # least squares without noise: the frequency is exact to about the solver's 1e-8
    assert properties.frequency == pytest.approx(FREQUENCY, rel=1e-7)
    assert properties.storage == pytest.approx(STIFFNESS, rel=1e-6)
    assert properties.loss == pytest.approx(
        loss, rel=1e-4
    )  # a phase error of 1e-8 x 100 rad falls on it with K'/K'' = 43
    assert properties.damping == pytest.approx(DAMPING, rel=1e-4)
    assert properties.loss_factor == pytest.approx(loss / STIFFNESS, rel=1e-4)
    assert properties.dynamic == pytest.approx(math.hypot(STIFFNESS, loss), rel=1e-6)
    assert properties.cycles == 15


def test_area_of_the_loop_gives_the_same_loss():
    properties = mount_properties(moved_mount(rate=5000.0))
    # trapezoids of an ellipse: (phase step)^2/6 = (0.01)^2/6; the loop is open by one sample of 9500, and by
    # K' over it: 43 x 1e-3
    assert properties.loop_loss == pytest.approx(properties.loss, rel=0.05)


def test_noise_of_the_force_averages_out_and_shows_in_the_scatter():
    properties = mount_properties(moved_mount(noise=5.0))
    # 5 N over 2000 samples: amplitude known to 5 sqrt(2/2000) = 0.16 N of 144 N; times 3
    assert properties.storage == pytest.approx(STIFFNESS, rel=3 * 0.16 / 144)
    # a cycle has 127 samples: 5 sqrt(2/127) = 0.63 N over 2 mm = 314 N/m; a deviation from 15 cycles is known
    # to 20 %, times 2.5
    assert properties.storage_scatter == pytest.approx(314.0, rel=0.5)


def test_stiffening_mount_shows_its_distortion_and_the_stiffness_of_the_first_harmonic():
    cubic = 1e10
    properties = mount_properties(moved_mount(cubic=cubic))
    # x^3 of a sine: 3/4 of it at the first harmonic, 1/4 at the third; about a mean displacement the spring
    # does not know
    assert properties.storage == pytest.approx(STIFFNESS + 0.75 * cubic * AMPLITUDE**2, rel=1e-3)
    assert properties.distortion == pytest.approx(
        0.25 * cubic * AMPLITUDE**3 / (properties.dynamic * AMPLITUDE), rel=0.02
    )


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (
            lambda t: t._replace(force=-t.force),
            "force: must lead the displacement by less than a quarter cycle",
        ),
        (lambda t: MountTest(*(column[:250] for column in t)), "test: needs 3 whole cycles, got 1"),
        (
            lambda t: MountTest(*(column[::20] for column in t)),
            "test: needs 12 samples in a cycle, got 6.3",
        ),
        (
            lambda t: MountTest(*(np.delete(column, slice(400, 650)) for column in t)),
            "test: has a gap: 0 samples in cycle 5 of 15",
        ),
        (lambda t: t._replace(time=t.time[::-1]), "time: does not rise after sample 1"),
        (lambda t: t._replace(displacement=np.zeros_like(t.time)), "displacement: is constant"),
        (
            lambda t: t._replace(displacement=t.displacement + 1e-3 * np.sin(700.0 * t.time)),
            "displacement: must be a sine of one frequency",
        ),
        (
            lambda t: t._replace(force=np.where(t.time == 0.005, math.nan, t.force)),
            "force: must be finite numbers, sample 6 is not",
        ),
    ],
    ids=["sign", "short", "coarse", "gap", "backwards", "still", "two frequencies", "nan"],
)
def test_record_that_is_no_such_test_is_refused(spoiled, message):
    with pytest.raises(CaseError) as raised:
        mount_properties(spoiled(moved_mount()))
    assert message in str(raised.value)


def write(path, test, head="time [ms],force [kN],displacement [mm]"):
    rows = [f"{1e3 * t},{1e-3 * f},{1e3 * x}" for t, x, f in zip(*test, strict=True)]
    path.write_text("\n".join([head, *rows]))


def test_columns_may_stand_in_any_order_and_unit(tmp_path):
    write(tmp_path / "a.csv", moved_mount())
    assert mount_properties(read_mount_test(tmp_path / "a.csv")).storage == pytest.approx(STIFFNESS, rel=1e-6)


def test_file_with_other_columns_or_cells_is_refused_with_its_line(tmp_path):
    write(tmp_path / "a.csv", moved_mount(), head="time [ms],force [kg],displacement [mm]")
    with pytest.raises(CaseError, match=r"a\.csv:1: must name time, displacement and force with their units"):
        read_mount_test(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text("time [s],displacement [mm],force [N]\n0,1,2\n0.1,x,\n")
    with pytest.raises(CaseError) as raised:
        read_mount_test(tmp_path / "b.csv")
    assert [str(fault).partition("b.csv")[2] for fault in raised.value.faults] == [
        ':3: column "displacement" must be a number, got "x"',
        ':3: column "force" must be a number, got ""',
    ]


def test_command_prints_the_properties_and_draws_the_loop(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "a.csv", moved_mount())
    reply = CliRunner().invoke(cli.app, ["mount-test", "a.csv"])
    assert reply.exit_code == 0, reply.output
    assert "storage stiffness  K'  72.2 N/mm" in reply.output
    assert "= 34 N s/m" in reply.output
    assert (tmp_path / "a.png").stat().st_size > 5000
