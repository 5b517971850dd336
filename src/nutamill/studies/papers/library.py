"""Read a paper's file: one of the two in the package, or one of the same form."""

from pathlib import Path

from nutamill.base.errors import CaseError, Fault
from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.files import MOST_CASE_TEXT, is_file, read_text
from nutamill.base.library import similar
from nutamill.case.toml.layers import Layer
from nutamill.case.toml.messages import checked
from nutamill.studies.papers.model import Paper

FOLDER = Path(__file__).parents[2] / "data" / "papers"


def paper_names() -> list[str]:
    """Return the names of the papers in the package."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def read_paper(name: str | Path) -> Paper:
    """Read a paper of the package, or one described by a TOML file of the same form.

    Raises
    ------
    CaseError : no such paper, or every fault of its file with line and key
    """
    path = FOLDER / f"{name}.toml" if name in paper_names() else Path(name)
    refuse_other_kind(path, FileKind.PAPER)
    if not is_file(path):
        raise CaseError(
            Fault(str(name), "no paper and no file has this name", similar(str(name), paper_names()))
        )
    try:
        text = read_text(path, MOST_CASE_TEXT)
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(Fault(str(name), f"cannot be read as text: {error}")) from None
    return parse_paper(text, path.name)


def parse_paper(text: str, shown: str) -> Paper:
    """Return the paper that TOML text describes. Messages call it `shown`. Raises CaseError as `read_paper`
    does.
    """
    layer = Layer.of_text(text, shown)
    return checked(Paper, layer.content, layer.places)
