"""What is read from statistics and snapshots whose answers are known."""

import math

import numpy as np
import pytest
import xarray

from nutamill.analysis.flow import (
    crest,
    crest_history,
    flow_fields,
    impact_spectra,
    loading_spectra,
    mass_centre_orbit,
    snapshot_heights,
    surface_heights,
    wear_table,
    window,
)
from nutamill.analysis.steady_table import steady
from nutamill.analysis.windows import steady_mean
from nutamill.base.errors import ResultError
from nutamill.result import Recorder, open_result
from nutamill.result.fields import STATISTICS
from nutamill.view.figures.charge import draw_flow, draw_spectra, draw_wall

RADII = np.array([0.01, 0.03, 0.05])
AZIMUTH = (np.arange(36) + 0.5) * math.tau / 36
HEIGHT = np.arange(20) * 0.01 + 0.005
AXES = {
    "pair": np.array(["steel-steel", "steel-acrylic wall"]),
    "pair_materials": np.array(["steel-steel", "steel-acrylic wall"]),
    "pair_first": np.array([0.005, 0.005]),
    "pair_second": np.array([0.005, np.nan]),
    "pair_share": np.array([0.5, 0.2]),
    "part": np.array(["normal", "tangential", "loading"]),
    "energy": 2.0 ** (np.arange(8) - 20.0),
    "radius": RADII,
    "azimuth": AZIMUTH,
    "height": HEIGHT,
    "cell_volume": np.repeat(RADII[:, None] * 0.02 * math.tau / 36, 20, axis=1) * 0.01,
    "neighbours": np.arange(16),
    "patch_surface": np.array(["bore"] * 8 + ["floor"]),
    "patch_column": np.array([0, 0, 1, 1, 2, 2, 3, 3, 0]),
    "patch_azimuth": np.array([0.5, 0.5, 2.0, 2.0, 3.5, 3.5, 5.5, 5.5, 1.0]),
    "patch_along": np.array([0.05, 0.15] * 4 + [0.03]),
    "patch_area": np.array([2.0] * 8 + [0.0]),
}
SIZES = {
    name: len(AXES[name]) for name in ("pair", "part", "energy", "radius", "azimuth", "height", "neighbours")
} | {"patch": 9}


def sums(time, **known):
    """Statistics at `time` [s]: `known` rates times the time, zero for the rest."""
    arrays = {}
    for field in STATISTICS:
        shape = [SIZES[part.strip()] for part in field.shape.strip("()").split(",") if part.strip()]
        arrays[field.name] = np.broadcast_to(known.get(field.name, 0.0), shape) * time
    arrays["sampled_time"] = np.float64(time)
    return arrays


TILT = 0.08 + 0.03 * np.cos(AZIMUTH - 2.0)
"""Height of a surface with its crest 2 rad ahead of the crank [m]."""


@pytest.fixture
def result(tmp_path):
    """A run whose mass centre is 0.7 rad behind the crank."""
    with open_result(recorded(tmp_path / "a.h5", 0.7)) as opened:
        yield opened


def recorded(path, lag):
    """Write four seconds at one turn a second; a bed of solids fraction 0.5 up to `TILT`, turning at 2 rad/s
    with some agitation. The mass centre is behind the crank by `lag` [rad], a number or a function of time.
    """
    filled = np.clip((TILT[:, None] - (HEIGHT - 0.005)) / 0.01, 0.0, 1.0) * np.ones((3, 1, 1))
    volume = 0.5 * AXES["cell_volume"][:, None, :] * filled
    mass = 1000.0 * volume
    speed = 2.0 * RADII[:, None, None]
    rates = {
        "cell_solid_volume": volume,
        "cell_mass": mass,
        "cell_momentum_a": mass * speed,
        "cell_square_speed": mass * (speed**2 + 3 * 0.04),
        "cell_particles": filled,
        "cell_neighbours": 6.0 * filled,
        "impact_number": 10.0,
        "impact_energy": 10.0 * AXES["energy"],
        "wall_load": 4.0,
        "wall_shear_work": 6.0,
        "wall_cutting_energy": np.arange(9.0),
    }
    time = np.arange(4001) / 1000.0
    angle = math.tau * time
    names = ["time", "crank_angle", "driveshaft_speed", *(f"charge_mass_centre_{axis}" for axis in "xyz")]
    behind = lag(time) if callable(lag) else np.full_like(time, lag)
    columns = [
        time,
        angle,
        np.full_like(time, math.tau),
        0.05 * np.cos(angle - behind),
        0.05 * np.sin(angle - behind),
        np.full_like(time, -0.25),
    ]
    if callable(lag):
        names, columns = [*names, "charge_phase_lag"], [*columns, np.pi - np.mod(np.pi - behind, math.tau)]
    recorder = Recorder.create(path, "", {}, names, 1000.0, axes=AXES)
    recorder.append(np.stack(columns, axis=1))
    for k in range(5):
        recorder.statistics(float(k), sums(float(k), **rates))
    recorder.close()
    return path


def test_statistics_come_back_with_units_and_axes(result):
    stored = result.statistics
    assert isinstance(stored, xarray.Dataset)
    assert stored["cell_momentum_a"].dims == ("time", "radius", "azimuth", "height")
    assert stored["cell_momentum_a"].attrs["units"] == "kg m"
    assert "turned about its axis by the crank angle" in stored["cell_momentum_a"].attrs["frame"]
    assert list(stored["pair"].values) == ["steel-steel", "steel-acrylic wall"]
    assert stored["time"].values.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("last", "start"), [(2.0, 2.0), ("1500 ms", 2.0), (1.0, 3.0), (0.1, 3.0), (100.0, 0.0)]
)
def test_window_begins_at_a_recorded_time_at_least_as_long_ago_as_asked(result, last, start):
    done = window(result, last)
    assert (done.attrs["start"], done.attrs["end"]) == (start, 4.0)
    assert float(done["sampled_time"]) == 4.0 - start
    assert done["wall_load"].values == pytest.approx(np.full(9, 4.0 * (4.0 - start)))


def test_spectra_wear_and_fields_are_rates_per_area_volume_and_mass(result):
    done = window(result, 2.0)
    spectra = impact_spectra(done)
    assert float(spectra["rate"].sum()) == pytest.approx(2 * 3 * 8 * 10.0)
    assert (spectra["power"] / spectra["rate"]).values == pytest.approx(
        np.broadcast_to(AXES["energy"], (2, 3, 8))
    )
    wear = wear_table(done)
    assert wear["pressure"].values[:8] == pytest.approx(np.full(8, 2.0))
    assert wear["shear_intensity"].values[:8] == pytest.approx(np.full(8, 3.0))
    assert wear["cutting_intensity"].values[:8] == pytest.approx(np.arange(8) / 2.0)
    assert np.isnan(wear["pressure"].values[8])
    fields = flow_fields(done)
    low = fields.isel(height=slice(0, 4))
    assert low["solids_fraction"].values == pytest.approx(np.full((3, 36, 4), 0.5))
    assert low["velocity_a"].transpose("radius", "azimuth", "height").values[:, 0, 0] == pytest.approx(
        2.0 * RADII
    )
    assert low["granular_temperature"].values == pytest.approx(np.full((3, 36, 4), 0.04))
    assert low["coordination"].values == pytest.approx(np.full((3, 36, 4), 6.0))
    assert np.isnan(fields["velocity_a"].isel(height=-1)).all()


def test_crest_and_phase_lag_of_a_tilted_surface(result):
    # Columns are filled evenly up to TILT: 95 % lie below 0.95 of it. A cell of 10 mm that is filled to a
    # share f counts as spread
    # evenly, which puts the height too high by at most max f (1 - f) of it, 2.5 mm; the amplitude is 28.5 mm.
    heights = surface_heights(window(result, 2.0))
    assert heights == pytest.approx(0.95 * TILT, abs=2.5e-3)
    wave = crest(0.95 * TILT, AZIMUTH)
    assert wave.height == pytest.approx(0.95 * TILT.max())
    assert wave.azimuth == AZIMUTH[np.argmax(TILT)]
    assert wave.mean_height == pytest.approx(0.95 * 0.08)
    assert wave.amplitude == pytest.approx(0.95 * 0.03)
    assert wave.phase_lag == pytest.approx(-2.0)  # ahead of the crank
    assert crest(heights, AZIMUTH).phase_lag == pytest.approx(-2.0, abs=2.5e-3 / 0.0285)


def attitude(axis, angle):
    """Unit quaternion of a turn about a unit axis."""
    return np.concatenate([[math.cos(angle / 2)], math.sin(angle / 2) * np.array(axis, float)])


def tilted_plane(crank_angle):
    """Balls of a cubic lattice below a plane that rises 0.5 m/m towards the azimuth 2 rad ahead of the crank,
    in a tilted chamber.
    """
    step = 0.002
    grid = np.arange(-24, 24) * step + step / 2
    x, y, z = (
        part.ravel() for part in np.meshgrid(grid, grid, np.arange(60) * step + step / 2, indexing="ij")
    )
    ahead = crank_angle + 2.0
    inside = (np.hypot(x, y) < 0.045) & (z < 0.05 + 0.5 * (x * math.cos(ahead) + y * math.sin(ahead)))
    places = np.stack([x, y, z], axis=1)[inside]
    tilt = 0.1
    turned = places @ np.array(
        [[math.cos(tilt), 0.0, -math.sin(tilt)], [0.0, 1.0, 0.0], [math.sin(tilt), 0.0, math.cos(tilt)]]
    )
    floor = np.array([0.03, -0.01, -0.3])
    return {
        "positions": turned + floor,
        "radii": np.full(len(places), step / 2),
        "chamber_floor": floor,
        "chamber_attitude": attitude((0, 1, 0), tilt),
    }


@pytest.mark.parametrize("crank_angle", [0.0, 4.0])
def test_crest_of_a_tilted_plane_of_particles_is_in_chamber_axes(crank_angle):
    # A sector's 95 % height follows from the volume of a wedge under the plane, integrated here on a fine
    # grid of radii. A layer
    # of balls is 2 mm high, its edge is ragged by as much: heights to 2 mm, the phase of their harmonic,
    # 0.015 m, to 2/15/sqrt(36)
    heights = snapshot_heights(tilted_plane(crank_angle), crank_angle)
    r = (np.arange(300) + 0.5) / 300 * 0.045
    z = np.linspace(0.0, 0.08, 2001)
    expected = []
    for azimuth in AZIMUTH:
        top = 0.05 + 0.5 * r * math.cos(azimuth - 2.0)
        below = (r[:, None] * np.minimum(z, top[:, None])).sum(axis=0)
        expected.append(np.interp(0.95 * below[-1], below, z))
    assert heights == pytest.approx(expected, abs=2e-3)
    assert crest(heights, AZIMUTH).phase_lag == pytest.approx(-2.0, abs=0.022)
    assert crest(heights, AZIMUTH).height == pytest.approx(max(expected), abs=2e-3)


def test_a_few_flying_particles_make_no_surface():
    low = tilted_plane(0.0)
    ahead = np.arctan2(*(low["positions"] - low["chamber_floor"])[:, 1::-1].T)
    chosen = np.abs(ahead) < 1.0
    chosen[np.flatnonzero(~chosen)[::200]] = True
    heights = snapshot_heights(
        {name: array[chosen] if len(array) == len(chosen) else array for name, array in low.items()}, 0.0
    )
    assert not heights[np.cos(AZIMUTH) < 0.3].any()
    assert heights[np.cos(AZIMUTH) > 0.7].all()


def test_crest_history_follows_the_crank(tmp_path):
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, ["time", "crank_angle"], 10.0)
    recorder.append(np.array([[0.0, 0.0], [1.0, 4.0]]))
    names = ("positions", "radii", "chamber_floor", "chamber_attitude")
    for time, angle in ((0.0, 0.0), (1.0, 4.0)):
        plane = tilted_plane(angle)
        number = len(
            tilted_plane(0.0)["radii"]
        )  # lattices of two angles differ by a few balls, snapshots of a file do not
        plane["positions"] = np.resize(plane["positions"], (number, 3))
        plane["radii"] = np.resize(plane["radii"], number)
        recorder.snapshot(time, {name: plane[name] for name in names})
    recorder.close()
    with open_result(tmp_path / "a.h5") as result:
        history = crest_history(result)
    assert history.time.tolist() == [0.0, 1.0]
    assert history.phase_lag == pytest.approx([-2.0, -2.0], abs=0.1)


def test_orbit_of_the_mass_centre_is_its_circle_behind_the_crank(result):
    orbit = mass_centre_orbit(result, 2.0)
    assert orbit == pytest.approx((0.05, 0.7, -0.25, 0.0), abs=1e-9)


@pytest.mark.parametrize("answer", [mass_centre_orbit, crest_history])
def test_a_machine_without_a_crank_has_no_axes_that_turn_with_it(tmp_path, answer):
    names = ["time", *(f"charge_mass_centre_{axis}" for axis in "xyz")]
    Recorder.create(tmp_path / "a.h5", "", {}, names, 1.0).close()
    with open_result(tmp_path / "a.h5") as result, pytest.raises(ResultError, match="has no crank"):
        answer(result)


@pytest.mark.parametrize(
    ("names", "advice"),
    [
        (["time", "charge_mass_centre_x"], "Run it with run.statistics = true"),
        (["time"], "its chamber is empty. Run a case with a charge"),
    ],
)
def test_a_result_without_statistics_says_how_to_get_them(tmp_path, names, advice):
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, names, 1.0)
    recorder.close()
    with (
        open_result(tmp_path / "a.h5") as result,
        pytest.raises(ResultError, match=advice.replace(".", r"\.")),
    ):
        window(result)


def test_two_bodies_share_the_work_of_loading_inversely_to_their_stiffness(result):
    # 0.2 and 0.8 of the energies of a pair of half-octave bins: 4.6 and 0.6 bins lower
    shared = loading_spectra(result, 2.0)
    whole = 10.0 * AXES["energy"].sum()
    power = shared["power"].sum("energy").sel(pair="steel-acrylic wall").values
    assert power == pytest.approx([0.2 * whole, 0.8 * whole])
    assert shared["rate"].sum("energy").values == pytest.approx(80.0 * np.ones((2, 2)))
    halves = shared["power"].sel(pair="steel-steel").values
    assert halves[0] == pytest.approx(halves[1])


@pytest.mark.parametrize(("draw", "labels"), [(draw_spectra, 2), (draw_wall, 6), (draw_flow, 4)])
def test_figures_of_the_charge_have_labelled_axes(result, draw, labels):
    figure = draw(result, 2.0)
    assert len(figure.axes) == labels
    assert all(axes.get_xlabel() or axes.get_ylabel() or axes.name == "polar" for axes in figure.axes)


def test_the_lag_on_the_flow_is_that_of_the_mass_centre_as_on_the_orbit(result):
    """0.7 rad are 40 deg, while the crest of the surface is 2 rad ahead of the crank."""
    words = [text.get_text() for text in draw_flow(result, 2.0).legends[0].get_texts()]
    assert words[1].startswith("lag 40 deg: angle of the crank ahead of the\nmass centre of the charge")
    assert "lag" not in words[0]


@pytest.fixture
def drifting(tmp_path):
    """A run whose lag passes from pi to -pi and back, and drifts."""
    with open_result(
        recorded(tmp_path / "b.h5", lambda time: 3.0 + 0.3 * np.sin(9.0 * time) + 0.1 * time)
    ) as run:
        yield run


def test_the_lag_on_the_flow_and_in_the_table_is_one_number_in_one_unit(drifting):
    ((label, text),) = steady(drifting, "charge_phase_lag").rows()
    words = draw_flow(drifting, 2.0).legends[0].get_texts()[1].get_text()
    assert label == "charge phase lag (deg)"
    assert words.startswith(f"lag {float(text.partition(' ')[0]):.0f} deg")


def test_the_mean_of_a_lag_that_steps_from_pi_to_minus_pi_is_near_pi(drifting):
    # 3 + 0.1 t on average over 4 s, and not the mean of numbers on both sides of the step
    mean = steady_mean(drifting, "charge_phase_lag").mean
    assert mean % math.tau == pytest.approx(3.2, abs=0.1)
    assert mass_centre_orbit(drifting).phase_lag == mean


def test_spectra_are_drawn_where_there_are_impacts(result, monkeypatch):
    """A thousand impacts a second in bins 3 to 5 of eight, ten in bin 1, and very many weaker than any bin
    in the lowest.
    """
    from nutamill.analysis.flow import impact_spectra
    from nutamill.view.figures import charge

    def few(done):
        spectra = impact_spectra(done)
        for name, scale in (("rate", 1.0), ("power", AXES["energy"])):
            per_bin = scale * np.array([1e6, 10.0, 0.0, 1e3, 1e3, 1e3, 0.0, 0.0])
            if name == "power":
                per_bin[0] = 0.0
            spectra[name] = xarray.zeros_like(spectra[name]) + xarray.DataArray(per_bin, dims="energy")
        return spectra

    monkeypatch.setattr(charge, "impact_spectra", few)
    low, high = draw_spectra(result, 2.0).axes[0].get_xlim()
    assert low == pytest.approx(AXES["energy"][3])
    assert high == pytest.approx(2.0 * AXES["energy"][5])
