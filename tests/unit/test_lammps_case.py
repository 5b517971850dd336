"""A case whose charge LAMMPS is to move: what is refused, and the processes of a run."""

from types import SimpleNamespace

import pytest

from nutamill.base.errors import CaseError, NotInstalledError
from nutamill.case import load_case
from nutamill.charge.laws.pair import spring_stiffness
from nutamill.design.engine_choice import engine_lines
from nutamill.simulation.lammps import commands, faults, library, ranks, windows
from nutamill.simulation.lammps.faults import lammps_faults, refuse_for_lammps
from nutamill.simulation.lammps.lead import led
from nutamill.simulation.runs import run
from nutamill.simulation.setup.charge import pair_laws
from nutamill.simulation.setup.statistics import pair_types

ASKED = ["charge.engine=lammps", "charge.count=200"]


def machine_with(*changes):
    return load_case("numill", [*ASKED, *changes]).machine


@pytest.fixture
def started_by_mpi(monkeypatch):
    """A launcher of MPI has started as many processes as asked."""
    return lambda count: monkeypatch.setenv("PMI_SIZE", str(count))


def test_a_charge_that_lammps_can_move_has_no_faults():
    assert lammps_faults(machine_with()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("run.coupling=iterated", 'run.coupling: must be "staggered" or "prescribed" with charge.engine'),
        ("run.threads=2", 'run.threads: has no use with charge.engine = "lammps", got 2'),
        ("contact.rolling=type_a", "LAMMPS lacks type A rolling"),
    ],
)
def test_what_lammps_cannot_do_is_refused_by_name(change, message):
    with pytest.raises(CaseError) as refused:
        refuse_for_lammps(machine_with(change))
    assert message in str(refused.value)


def two_sizes():
    changes = ["charge.engine=lammps", "charge.sizes=[['4 mm', 0.5], ['6 mm', 0.5]]", "charge.count=200"]
    return load_case("numill", [*changes, "contact.stiffness=young"]).machine


def test_two_diameters_have_the_stiffness_of_each_pair():
    machine = two_sizes()
    law = pair_laws(machine)[0, 0]
    for (i, j), words in commands.pair_words(machine).items():
        stiffness = spring_stiffness(law, *((4e-3, 6e-3)[k] for k in (i, j)))
        assert float(words.split()[1]) == pytest.approx(stiffness, rel=1e-5)
    assert len(commands.pair_words(machine)) == 3


def test_sizes_that_differ_within_a_class_are_refused_where_stiffness_grows_with_them():
    sizes = "charge.sizes=[['4 mm', 0.5], ['4.2 mm', 0.5]]"
    with pytest.raises(CaseError, match="handed to LAMMPS for classes of one diameter each"):
        refuse_for_lammps(machine_with(sizes, "contact.stiffness=young"))
    pairs = [f"contact.pairs.{pair}.normal_stiffness=10 kN/m" for pair in ("steel-steel", "steel-acrylic")]
    assert lammps_faults(machine_with(sizes, "contact.stiffness=direct", *pairs)) == []


def test_impacts_are_counted_at_walls_alone():
    assert [pair.name for pair in pair_types(two_sizes())] == [
        "steel 4 mm-acrylic wall",
        "steel 6 mm-acrylic wall",
    ]


def test_a_wet_charge_stays_in_this_engine():
    film = {"liquid_viscosity": "50 mPa s", "film_thickness": "50 um", "film_roughness": "1 um"}
    pairs = ("steel-steel", "steel-acrylic")
    numbers = [f"contact.pairs.{pair}.{key}={value}" for pair in pairs for key, value in film.items()]
    with pytest.raises(CaseError, match="steel-steel: LAMMPS lacks a viscous film"):
        refuse_for_lammps(machine_with("contact.film=viscous", *numbers))


def test_more_surfaces_than_a_particle_has_memory_for_are_refused(monkeypatch):
    monkeypatch.setattr(faults, "MOST_SURFACES", 2)
    with pytest.raises(CaseError, match=r"walls: at most 2 surfaces with .*, got 3"):
        refuse_for_lammps(machine_with())


def test_all_faults_are_reported_at_once():
    with pytest.raises(CaseError) as refused:
        refuse_for_lammps(machine_with("run.coupling=iterated", "run.threads=2", "contact.rolling=type_a"))
    assert len(refused.value.faults) >= 3


def test_a_run_is_refused_before_its_file_is_made(tmp_path):
    with pytest.raises(CaseError, match="LAMMPS cannot go back to the start of a window"):
        run(load_case("numill", [*ASKED, "run.coupling=iterated"]), tmp_path / "a.h5")
    assert not list(tmp_path.iterdir())


def test_more_processes_than_particles_can_use_are_refused(started_by_mpi):
    started_by_mpi(8)
    with pytest.raises(CaseError, match="8 processes share 200 particles, fewer than 50 each"):
        refuse_for_lammps(machine_with())


def test_copies_of_a_run_that_shares_nothing_are_refused(started_by_mpi):
    started_by_mpi(2)
    with (
        pytest.raises(CaseError, match="mpiexec has started 2 processes, which would all run the same case"),
        led(load_case("numill").machine),
    ):
        pass


@pytest.mark.parametrize(
    ("environment", "count", "behind"),
    [
        ({}, 1, False),
        ({"PMI_SIZE": "4", "PMI_RANK": "0"}, 4, False),
        ({"PMI_SIZE": "4", "PMI_RANK": "3"}, 4, True),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "1"}, 2, True),
    ],
)
def test_a_launcher_says_how_many_processes_there_are(environment, count, behind):
    assert (ranks.launched(environment), ranks.follows(environment)) == (count, behind)


class Engine:
    """A LAMMPS of some version, with some packages."""

    installed_packages = ("GRANULAR",)

    def __init__(self, cmdargs, comm):
        self.closed = False

    def version(self):
        return library.OLDEST

    def close(self):
        self.closed = True


class Old(Engine):
    def version(self):
        return 20200303


class Bare(Engine):
    installed_packages = ("MOLECULE",)


class NoMpi(Engine):
    def __init__(self, cmdargs, comm):
        raise OSError("libmpi.so.12: cannot open shared object file")


@pytest.mark.parametrize(
    ("engine", "message"),
    [
        (None, 'charge.engine = "lammps" needs LAMMPS, which is not installed'),
        (NoMpi, "needs a library of MPI (libmpi.so.12: cannot open shared object file)"),
        (Old, f"needs LAMMPS {library.OLDEST} or newer, got 20200303"),
        (Bare, "needs a LAMMPS with the package GRANULAR, this one has none"),
    ],
)
def test_a_lammps_that_cannot_be_used_is_a_line(monkeypatch, engine, message):
    module = None if engine is None else type("Module", (), {"lammps": engine})
    monkeypatch.setitem(__import__("sys").modules, "lammps", module)
    with pytest.raises(NotInstalledError) as missing:
        library.start_lammps(None)
    assert message in str(missing.value)
    assert "\n" not in str(missing.value)


def test_processes_that_have_read_different_cases_are_refused(monkeypatch):
    class Two(ranks.Ranks):
        size = 2

        def gathered(self, rows):
            import numpy as np

            return np.concatenate([rows, rows + 1])

    from nutamill.simulation.lammps.lead import agree

    with pytest.raises(CaseError, match="1 of 2 processes have read another case than the first"):
        agree(machine_with(), Two())


def test_fmus_beside_lammps_are_refused():
    machine = machine_with().model_copy(update={"fmus": ("a model",)})
    messages = [str(CaseError(fault)) for fault in lammps_faults(machine)]
    assert any('fmus: are not run with charge.engine = "lammps"' in message for message in messages)


def test_a_lammps_that_stops_ends_the_march_with_its_words(monkeypatch):
    def stopped(*_):
        raise RuntimeError("ERROR: Out of range atoms\n - cannot compute")

    left = []
    grains = SimpleNamespace(ranks=SimpleNamespace(order=lambda _: None, leave=lambda: left.append(True)))
    state = SimpleNamespace(grains=grains, charge=object(), mechanism=SimpleNamespace(time=[0.25]))
    monkeypatch.setattr(windows, "march_windows", stopped)
    written, fault = windows.march_grains(SimpleNamespace(charge=object()), state, None, 1, None)
    assert written == 0 and left
    assert str(fault) == "t = 0.25 s: LAMMPS stopped: ERROR: Out of range atoms - cannot compute"


@pytest.mark.parametrize(
    ("theirs", "ours", "line"),
    [
        (6.3, 2.0, "LAMMPS on one process takes 3.1 times as long as this program on 1 thread: it pays from "
         "some 4 processes on"),
        (1.0, 2.0, "LAMMPS on one process takes 0.5 times as long as this program on 1 thread: it pays"),
        (None, 2.0, "not tried: after a first run with LAMMPS and one without, check says when it pays"),
    ],
)  # fmt: skip
def test_check_says_when_lammps_pays(monkeypatch, theirs, ours, line):
    monkeypatch.setattr("nutamill.design.engine_choice.team_size", lambda machine: 1)
    asked = []

    def trial(machine):
        asked.append(machine.charge.engine)
        return ours

    assert engine_lines(machine_with(), theirs, trial) == [f"engine    {line}"]
    assert asked == ([] if theirs is None else [None])


def test_check_is_silent_on_lammps_where_nobody_asks_for_it():
    assert engine_lines(load_case("numill").machine, 1.0, lambda machine: 2.0) == []
    assert engine_lines(machine_with(), None, None) == []


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (ImportError("no module"), "a run on several processes needs mpi4py, which is not installed"),
        (RuntimeError("cannot load MPI library"), "needs a library of MPI (cannot load MPI library)"),
    ],
)
def test_several_processes_without_mpi_are_a_line(monkeypatch, started_by_mpi, fault, message):
    started_by_mpi(2)

    class Missing:
        def __getattr__(self, name):
            raise fault

    monkeypatch.setitem(__import__("sys").modules, "mpi4py", Missing())
    with pytest.raises(NotInstalledError) as missing:
        ranks.all_ranks.__wrapped__()
    assert message in str(missing.value)
    assert "\n" not in str(missing.value)
