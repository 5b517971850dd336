"""The result file: `Recorder` writes it, `Result` reads it, and its layout is stated here, once.

One HDF5 file, no pickles, plain enough for any HDF5 reader::

    /                     attributes: format, format_version, state, rate [Hz]
    /case                 the case file as text (TOML)
    /provenance           attributes: versions, digest of the kernels, seed, threads, processor, wall_time
    /series/<name>        one number per sample; `time` is their common scale; attributes: units, long_name,
                          symbol ... (attribute `names` of the group: their order as recorded)
    /snapshots/<name>     one array per snapshot, first axis `time`
    /statistics/<name>    cumulative sums over what the charge did, first axis `time`
    /statistics/axes/...  the axes of these sums
    /walls/<key>/         a meshed wall: vertices [m], axes of its carrier from the mass centre, triangles
    /checkpoints/a, b     the two newest; attributes: time, rows, snapshots, statistics; <group>/<array>
                          restore a run bit for bit
    /summary              attributes: what was printed at the end
    /checksums            text: a digest of every object above, compared on reading
    /checksums_copy       the same again

Files of format 1 hold no checksums: they are read, shown as not verifiable, and not resumed.
The file is whole at every instant (`nutamill.base.atomic_file`): a commit replaces it by a copy with the new
samples added.  Its cost therefore grows with the file, and so does the pause between two commits.
"""

from nutamill.result.layout import Checkpoint, WallMesh
from nutamill.result.reader import MISSING, NOT_STEADY, Result, Snapshots, is_finished, open_result, state_of
from nutamill.result.recorder import Recorder
from nutamill.result.verification import Verification, verify

__all__ = [
    "MISSING",
    "NOT_STEADY",
    "Checkpoint",
    "Recorder",
    "Result",
    "Snapshots",
    "Verification",
    "WallMesh",
    "is_finished",
    "open_result",
    "state_of",
    "verify",
]
