"""A file is replaced whole, never through a link, and a system that refuses is reported in one sentence."""

import errno
import os
import stat
from pathlib import Path

import pytest

from nutamill.base import atomic_file
from nutamill.base.atomic_file import SPARE, replace_file, tidy, write_whole
from nutamill.base.errors import ResultError


def free_bytes(monkeypatch, number):
    """Let the disk have so many bytes free."""
    monkeypatch.setattr(
        atomic_file.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": number})()
    )


def refuse(monkeypatch, error):
    """Let the system refuse to create or remove a file."""

    def refused(*args, **kwargs):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr(atomic_file.os, "open", refused)
    monkeypatch.setattr(Path, "unlink", refused)


def test_link_made_beforehand_under_the_hidden_name_is_neither_followed_nor_put_in_place(
    tmp_path, monkeypatch
):
    victim, page = tmp_path / "victim.txt", tmp_path / "page.html"
    victim.write_text("mine")
    monkeypatch.setattr(
        atomic_file.secrets, "token_hex", lambda n: "0" * 2 * n
    )  # the attacker has guessed the name
    for name in (f".page.html.{os.getpid()}.part", f".page.html.{os.getpid()}-00000000.part"):
        (tmp_path / name).symlink_to(victim)
    with pytest.raises(ResultError, match="File exists"):
        write_whole(page, "<html>")
    monkeypatch.undo()
    write_whole(page, "<html>")
    assert (page.read_text(), page.is_symlink(), victim.read_text()) == ("<html>", False, "mine")


def test_system_without_the_flag_for_links_still_refuses_them(tmp_path, monkeypatch):
    monkeypatch.delattr(os, "O_NOFOLLOW", raising=False)
    test_link_made_beforehand_under_the_hidden_name_is_neither_followed_nor_put_in_place(
        tmp_path, monkeypatch
    )


def test_read_only_file_system_is_reported_in_one_sentence(tmp_path, monkeypatch):
    refuse(monkeypatch, errno.EROFS)
    with pytest.raises(ResultError) as raised:
        write_whole(tmp_path / "page.html", "<html>")
    assert str(raised.value) == (
        f'{tmp_path / "page.html"}: cannot be written, the system reports "Read-only file system". '
        "Choose another place."
    )


def test_failure_of_the_system_while_a_copy_is_changed_is_reported_though_the_copy_cannot_be_removed(
    tmp_path, monkeypatch
):
    def edit(part):
        refuse(monkeypatch, errno.EROFS)
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with pytest.raises(ResultError, match="Input/output error"):
        replace_file(tmp_path / "a.h5", edit, 0, b"content")


def test_reserve_of_the_disk_is_named_and_the_file_spoken_of_only_if_there_is_one(tmp_path, monkeypatch):
    free_bytes(monkeypatch, SPARE + 999_999)
    with pytest.raises(ResultError) as first:
        replace_file(tmp_path / "a.h5", lambda part: None, 1_000_000, b"")
    assert str(first.value) == (
        f"{tmp_path / 'a.h5'}: saving needs 1.0 MB, 17.8 MB are free, and a reserve of 16.8 MB must "
        "stay free."
        " Free some room, or choose another place."
    )
    (tmp_path / "a.h5").write_bytes(b"old")
    with pytest.raises(ResultError, match=r"\. The file is unchanged since it was last saved\.$"):
        replace_file(tmp_path / "a.h5", lambda part: None, 1_000_000)
    free_bytes(monkeypatch, SPARE + 1_000_003)
    replace_file(tmp_path / "a.h5", lambda part: None, 1_000_000)


@pytest.mark.skipif(not hasattr(os, "O_DIRECTORY"), reason="the system cannot flush a folder")
def test_folder_is_flushed_after_the_new_name_is_in_it(tmp_path, monkeypatch):
    flushed, fsync = [], os.fsync

    def note(number):
        if stat.S_ISDIR(os.fstat(number).st_mode):
            flushed.append((tmp_path / "a.txt").read_text())
        fsync(number)

    monkeypatch.setattr(os, "fsync", note)
    write_whole(tmp_path / "a.txt", "new")
    assert flushed == ["new"]


@pytest.mark.parametrize("lacking", ["posix_fallocate", "O_DIRECTORY", "O_NOFOLLOW"])
def test_file_is_replaced_on_a_system_without(lacking, tmp_path, monkeypatch):
    monkeypatch.delattr(os, lacking, raising=False)
    (tmp_path / "a.txt").write_text("old")
    replace_file(tmp_path / "a.txt", lambda part: part.write_text("new"), 8)
    assert (tmp_path / "a.txt").read_text() == "new"
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]


def test_copies_left_by_a_killed_writer_of_a_name_with_brackets_are_removed_and_no_others(tmp_path):
    for name in (".a[1].h5.12-ab.part", ".a1.h5.12-ab.part", "a[1].h5"):
        (tmp_path / name).touch()
    tidy(tmp_path / "a[1].h5")
    assert sorted(file.name for file in tmp_path.iterdir()) == [".a1.h5.12-ab.part", "a[1].h5"]


def test_folder_that_cannot_be_made_is_reported_before_a_sweep_begins(tmp_path):
    from nutamill.studies.sweep import run_all

    (tmp_path / "file").touch()
    with pytest.raises(ResultError, match=r"file.sweep.table\.csv: cannot be written"):
        run_all([], tmp_path / "file" / "sweep", workers=None)
