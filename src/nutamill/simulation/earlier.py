"""What a file holds that stands where a run is to write: nothing yet, the finished run of the same case, or
something to keep.
"""

from pathlib import Path

from nutamill.base.errors import CaseError, DamagedError, ResultError
from nutamill.base.files import exists
from nutamill.case import Case, Machine, case_of_text
from nutamill.result.reader import Result, is_finished, open_result


def earlier_result(path: Path, case: Case | Machine) -> Result | None:
    """Return the finished result of `case` at `path`, or None where a run may begin: no file, or one of a run
    that ended before its first save.

    Raises
    ------
    ResultError : the file is no readable result, holds another case, or is incomplete
    DamagedError : the result is damaged
    """
    if not exists(path):
        return None
    result = _readable(path)
    finished = False
    try:
        if _is_empty(result):
            return None
        if not _is_of(result, case):
            raise ResultError(
                f"{path}: holds another case. Choose another file with --to, or replace it with --again."
            )
        if not is_finished(result.state):
            raise ResultError(
                f"{path}: is incomplete, it ends at {result.reached:g} s of {case.run.end:g} s "
                f"({result.state})."
                f" Continue it with: nutamill resume {path}. Or begin anew with --again."
            )
        finished = True
        return result
    finally:
        if not finished:
            result.close()


def path_beside(path: Path) -> Path:
    """Return the path at which a run is written that replaces the result at `path`: beside it, so that the
    old one stays until the new one is whole.

    An empty result is replaced where it is; a damaged one stays as well.

    Raises
    ------
    ResultError : the file at `path` is no readable result, which no run replaces
    """
    if not exists(path):
        return path
    with _readable(path) as result:
        try:
            empty = _is_empty(result)
        except DamagedError:
            empty = False
    return path if empty else path.with_name(f"{path.stem}.again{path.suffix}")


def _readable(path: Path) -> Result:
    try:
        return open_result(path)
    except ResultError as error:
        raise ResultError(
            f"{error} No run replaces this file: choose another with --to, or remove it."
        ) from error


def _is_empty(result: Result) -> bool:
    return not result.reached and not result.has_checkpoint


def _is_of(result: Result, case: Case | Machine) -> bool:
    try:
        return case_of_text(result.case_text).digest == case.digest
    except CaseError:  # of a version with other keys
        return False
