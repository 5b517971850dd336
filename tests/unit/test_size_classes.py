"""Impacts are counted by classes of size, and the classes change no bit of a run."""

import numpy as np
import pytest
from test_march import OVERRIDES, bed

from nutamill.case import load_case
from nutamill.result import open_result
from nutamill.simulation import runs
from nutamill.simulation.setup import kinds
from nutamill.simulation.setup.kinds import particle_kinds, size_classes
from nutamill.simulation.setup.statistics import pair_types

TWO_SIZES = [
    *OVERRIDES,
    'charge.sizes=[["4 mm", 0.3], ["5 mm", 0.7]]',
    "charge.mass=0.03 kg",
    "run.until=20 ms",
]


def test_a_few_sizes_are_a_class_each_and_many_have_equal_ratios():
    assert size_classes(np.array([5e-3, 4e-3, 5e-3])).tolist() == [1, 0, 1]
    assert size_classes(np.array([5e-3, 5.1e-3, 5.2e-3, 5.3e-3])).tolist() == [0, 0, 0, 0]
    # from 1 to 8 mm in three classes: 2 and 4 mm are the inner ends
    many = np.array([1.0, 1.9, 2.1, 3.9, 4.1, 8.0])
    assert size_classes(many).tolist() == [0, 0, 1, 1, 2, 2]
    assert size_classes(np.array([1.0, 1.1, 7.0, 7.5, 8.0])).tolist() == [0, 0, 1, 1, 1]


def test_pairs_are_named_by_material_and_class_and_have_the_sizes_of_both():
    pairs = pair_types(load_case("numill", TWO_SIZES).machine)
    assert [pair.name for pair in pairs] == [
        "steel 4 mm-steel 4 mm",
        "steel 4 mm-steel 5 mm",
        "steel 5 mm-steel 5 mm",
        "steel 4 mm-acrylic wall",
        "steel 5 mm-acrylic wall",
    ]
    assert {pair.materials for pair in pairs} == {"steel-steel", "steel-acrylic wall"}
    assert pairs[1].diameters == pytest.approx((0.004, 0.005)) and np.isnan(pairs[3].diameters[1])
    types = [number for pair in pairs for number in pair.types]
    assert len(types) == len(set(types)) == 6
    (alone, wall) = pair_types(load_case("numill", OVERRIDES).machine)
    assert (alone.name, wall.name) == ("steel-steel", "steel-acrylic wall")


def test_classes_change_no_bit_and_their_impacts_add_up_to_those_without(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "settled_bed", bed)
    case = load_case("numill", TWO_SIZES)
    runs.run(case, tmp_path / "classes.h5").close()
    assert len(particle_kinds(case.machine).kinds) == 3
    monkeypatch.setattr(kinds, "NARROW", 10.0)
    particle_kinds.cache_clear()
    runs.run(case, tmp_path / "one.h5").close()
    particle_kinds.cache_clear()
    with open_result(tmp_path / "classes.h5") as classes, open_result(tmp_path / "one.h5") as one:
        assert classes.series.drop_attrs().identical(one.series.drop_attrs())
        by_class, together = classes.statistics.isel(time=-1), one.statistics.isel(time=-1)
    assert together["pair"].values.tolist() == ["steel-steel", "steel-acrylic wall"]
    for name in ("impact_number", "impact_energy"):
        sums = by_class[name].groupby("pair_materials").sum()
        for materials in together["pair"].values:
            exact = together[name].sel(pair=materials).values
            assert sums.sel(pair_materials=materials).values == pytest.approx(exact, rel=1e-14, abs=0.0)
    seen = by_class["impact_number"].sel(part="normal").sum("energy")
    assert (seen > 0.0).sum() >= 2


def test_bodies_share_the_work_of_loading_inversely_to_their_stiffness():
    # springs in series, E d each, a wall with the particle's diameter; Hertz: (1 - nu^2)/E, at any size
    machine = load_case("numill", [*TWO_SIZES, "contact.stiffness=young"]).machine
    steel, acrylic = machine.materials["steel"], machine.materials["acrylic"]
    shares = {pair.name: pair.share for pair in pair_types(machine)}
    assert shares["steel 4 mm-steel 4 mm"] == pytest.approx(0.5)
    small, large = (kind.diameter for kind in particle_kinds(machine).kinds[:2])
    assert shares["steel 4 mm-steel 5 mm"] == pytest.approx(large / (small + large))
    soft = acrylic.young_modulus / (acrylic.young_modulus + steel.young_modulus)
    for name in ("steel 4 mm-acrylic wall", "steel 5 mm-acrylic wall"):
        assert shares[name] == pytest.approx(soft)
    hertz = load_case(
        "numill", [*TWO_SIZES, "contact.normal=hertz", "contact.tangential=incremental"]
    ).machine
    a, b = ((1 - one.poisson_ratio**2) / one.young_modulus for one in (steel, acrylic))
    shares = {pair.name: pair.share for pair in pair_types(hertz)}
    assert shares["steel 4 mm-steel 5 mm"] == pytest.approx(0.5)
    assert shares["steel 5 mm-acrylic wall"] == pytest.approx(a / (a + b))
    # a machine that gives one stiffness for a pair says nothing of the two
    pairs = [f"contact.pairs.steel-{other}.normal_stiffness=1e5 N/m" for other in ("steel", "acrylic")]
    direct = load_case("numill", [*TWO_SIZES, "contact.stiffness=direct", *pairs]).machine
    assert {pair.share for pair in pair_types(direct)} == {0.5}
