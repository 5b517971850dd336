"""How to cite nutamill and the papers whose machines and measurements it ships."""

from typing import NamedTuple

from nutamill import __version__


class Paper(NamedTuple):
    """A journal article."""

    key: str
    """Name of its BibTeX entry."""
    authors: tuple[str, ...]
    """Surname and initials of each."""
    title: str
    """Its title."""
    journal: str
    """Name of the journal."""
    volume: str
    """Volume, and number where there is one."""
    pages: str
    """First and last page, or the number of the article."""
    year: int
    """Year of publication."""

    @property
    def text(self) -> str:
        """The reference in one line."""
        authors = ", ".join(f"{initials} {name}" for name, initials in (a.split(", ") for a in self.authors))
        return f"{authors}, {self.title}, {self.journal} {self.volume}, {self.pages}, {self.year}."

    @property
    def bibtex(self) -> str:
        """The reference as an entry of BibTeX."""
        return (
            f"@article{{{self.key},\n  author = {{{' and '.join(self.authors)}}},\n"
            f"  title = {{{self.title}}},\n  journal = {{{self.journal}}},\n  volume = {{{self.volume}}},\n"
            f"  pages = {{{self.pages}}},\n  year = {{{self.year}}}\n}}"
        )


SOFTWARE = (
    f"nutamill {__version__}: coupled multibody and particle dynamics of nutating mills. Open-source "
    "software, MIT licence."
)
PAPERS = (
    Paper(
        "jansevanvuuren2026",
        ("Janse van Vuuren, H. C.", "Bredell, J. R.", "Coetzee, C. J."),
        "Coupled multi-body and particle dynamics simulation of a nutating mill",
        "Math. Comput. Appl.",
        "31(5)",
        "171",
        2026,
    ),
    Paper(
        "vantonder2025",
        ("van Tonder, J. J.", "Bredell, J. R.", "Coetzee, C.", "Branehog, J."),
        "Simulation of kinetic joint forces in a nutating grinding mill",
        "J. S. Afr. Inst. Min. Metall.",
        "125",
        "99-106",
        2025,
    ),
)


def citation_lines(bibtex: bool = False) -> list[str]:
    """Return how to cite the package and the papers, as text or as entries of BibTeX."""
    if not bibtex:
        return [SOFTWARE, *(paper.text for paper in PAPERS)]
    software = (
        "@software{nutamill,\n  author = {{The nutamill developers}},\n"
        "  title = {nutamill: coupled multibody and particle dynamics of nutating mills},\n"
        f"  version = {{{__version__}}}\n}}"
    )
    return [software, *(paper.bibtex for paper in PAPERS)]
