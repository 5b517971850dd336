"""The file for ParaView, read back by VTK: parts, times, places and what the charge carries."""

import numpy as np
import pytest

from nutamill.base.errors import ResultError
from nutamill.view.vtkhdf import write_vtkhdf

pytestmark = pytest.mark.external


@pytest.fixture(autouse=True)
def _vtk():
    pytest.importorskip("vtkmodules.vtkIOHDF", reason='needs VTK, of the extra "view"')


def reader_of(path):
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    return reader


def read(path, time):
    """Times of a file, and its parts at one of them, by name."""
    from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet

    asked = reader_of(path)
    asked.UpdateInformation()
    times = asked.GetOutputInformation(0).Get(asked.GetExecutive().TIME_STEPS())
    reader = reader_of(
        path
    )  # a reader of VTK 9.7 that has been asked for the times of parts no longer finds them
    reader.UpdateTimeStep(time)
    whole = reader.GetOutputDataObject(0)
    name = vtkCompositeDataSet.NAME()
    return times, {
        whole.GetMetaData(k).Get(name): whole.GetPartition(k, 0)
        for k in range(whole.GetNumberOfPartitionedDataSets())
    }


def points(part):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(part.GetPoints().GetData())


@pytest.mark.parametrize("step", [0, 7, 19])
def test_vtk_reads_the_charge_at_any_time(filmed, tmp_path, step):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    snapshot = filmed.snapshots[step]
    times, parts = read(write_vtkhdf(filmed, tmp_path / "a.vtkhdf"), snapshot["time"])
    assert np.allclose(times, filmed.snapshots.time, atol=0)
    charge = parts["charge"]
    assert charge.GetNumberOfVerts() == 300
    assert np.array_equal(points(charge), snapshot["positions"])
    carried = {
        charge.GetPointData().GetArrayName(k): vtk_to_numpy(charge.GetPointData().GetArray(k))
        for k in range(2)
    }
    assert np.array_equal(carried["velocity"], snapshot["velocities"])
    assert np.array_equal(carried["radius"], snapshot["radii"])


def test_chamber_wall_encloses_the_pellets_at_every_time(filmed, tmp_path):
    """Along the chamber's axis and across, the pellets' centres lie within the wall's box, in chamber
    axes.
    """
    path = write_vtkhdf(filmed, tmp_path / "a.vtkhdf")
    for snapshot in (filmed.snapshots[3], filmed.snapshots[-1]):
        parts = read(path, snapshot["time"])[1]
        w, v = snapshot["chamber_attitude"][0], snapshot["chamber_attitude"][1:]
        own = [
            place - 2 * np.cross(v, w * place - np.cross(v, place))
            for place in (points(parts["chamber wall"]), points(parts["charge"]))
        ]  # turned back by the conjugate quaternion; the nutation point of the film rests at the origin
        assert np.all(own[0].min(axis=0) < own[1].min(axis=0))
        assert np.all(own[1].max(axis=0) < own[0].max(axis=0))
        assert np.hypot(*own[0][:, :2].T).max() == pytest.approx(0.07 + 0.035 * 0.14, rel=1e-5)


def test_result_without_snapshots_is_refused_and_no_file_is_left(unfilmed, tmp_path):
    with pytest.raises(ResultError, match="holds no snapshots"):
        write_vtkhdf(unfilmed, tmp_path / "a.vtkhdf")
    assert not (tmp_path / "a.vtkhdf").exists()
