"""A changed case says what was changed: it never keeps a title that its values contradict, and its identity
stays what it was.
"""

import pytest

from nutamill.case import case_of_text, load_case

NUMILL = "NuMill 2026: flexible mounts, unribbed chamber, steel pellets, 700 rpm"
CHANGES = ["chamber.ribs=12", "mechanism.mounting=rigid", "drive.speed=300 rpm"]
CHANGED = "numill-2026 with chamber.ribs = 12, mechanism.mounting = rigid, drive.speed = 300 rpm"


@pytest.mark.parametrize(
    ("changes", "title"),
    [
        ([], NUMILL),
        (CHANGES, CHANGED),
        (["drive.speed=700 rpm", "chamber.ribs=0"], NUMILL),  # the values it has
        (["run.threads=2"], NUMILL),  # changes nothing of what is simulated
        (["mounts.set=343"], "numill-2026 with mounts.set = 343"),  # one word, not the ten values behind it
        (["charge.count=100"], "numill-2026 with charge.count = 100"),  # instead of the mass
        (["chamber.ribs=12", "title=Ribs"], "Ribs"),
        (
            [
                f"run.{key}"
                for key in (
                    "seed=2",
                    "window=5",
                    "until=2 s",
                    "dt=1 us",
                    "checkpoint=2 s",
                    "series_rate=2400 Hz",
                )
            ],
            None,
        ),
    ],
)
def test_a_title_says_what_differs_from_the_case_it_belonged_to(changes, title):
    many = (
        "numill-2026 with run.seed = 2, run.window = 5, run.until = 2 s, run.dt = 1 us, run.checkpoint = "
        "2 s and 1 more"
    )
    assert load_case("numill", changes).title == (title or many)


def test_changes_in_python_are_changes_too_and_can_be_taken_back():
    mill = load_case("numill")
    slow = mill.with_("drive.speed", "300 rpm")
    assert slow.title == "numill-2026 with drive.speed = 300 rpm"
    assert slow.with_(chamber__ribs=12).title == "numill-2026 with drive.speed = 300 rpm, chamber.ribs = 12"
    assert slow.with_("drive.speed", mill.drive.speed).title == NUMILL
    assert slow.with_("title", "Slow").title == "Slow"
    typed = load_case("numill", ["chamber.ribs=12"])
    assert (
        typed.with_("drive.speed", "300 rpm").title
        == "numill-2026 with chamber.ribs = 12, drive.speed = 300 rpm"
    )


def test_a_title_is_the_users_word_where_he_changed_the_values_himself(tmp_path):
    own, untitled, above = (tmp_path / f"{name}.toml" for name in ("own", "untitled", "above"))
    own.write_text('base = "numill"\ntitle = "Mine"\n[drive]\nspeed = "500 rpm"\n')
    untitled.write_text('base = "numill"\n[drive]\nspeed = "500 rpm"\n')
    above.write_text('base = "own.toml"\n[chamber]\nribs = 12\n')
    assert load_case(own).title == "Mine"
    assert load_case(own, ["chamber.ribs=12"]).title == load_case(above).title == "own with chamber.ribs = 12"
    assert load_case(untitled).title == "numill-2026 with drive.speed = 500 rpm"


def test_a_derived_title_is_no_part_of_the_identity_and_travels_with_the_case():
    """The name of a result holds the digest: it is that of the same values under the title they were changed
    from.
    """
    changed = load_case("numill", CHANGES)
    assert changed.digest == load_case("numill", [*CHANGES, f"title={NUMILL}"]).digest
    assert changed.digest != load_case("numill", [*CHANGES, "title=Mine"]).digest
    again = case_of_text(changed.to_toml())
    assert (again.title, again.changed_from, again.digest) == (CHANGED, NUMILL, changed.digest)
    assert again.with_("drive.speed", "400 rpm").digest == changed.with_("drive.speed", "400 rpm").digest


def test_a_changed_mechanism_says_so_and_a_case_without_a_title_gets_none(tmp_path):
    text = 'TITLE[[bodies]]\nname = "ball"\nmass = "1 kg"\nposition = ["0 m", "0 m", "0 m"]\n'
    text += 'inertia = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]\n'
    file = tmp_path / "ball.toml"
    for title, expected in (('title = "A ball"\n', "ball with bodies.ball.mass = 2 kg"), ("", "")):
        file.write_text(text.replace("TITLE", title) + '[run]\nuntil = "1 s"\n')
        assert load_case(file, ["bodies.ball.mass=2 kg"]).title == expected
