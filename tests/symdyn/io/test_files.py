"""Files are whole or absent, whatever happens in between."""

from __future__ import annotations

import errno
import json
import math
import os
from pathlib import Path

import pytest

from symdyn.errors import FileProblem
from symdyn.io.files import read_json, replacing, writable_directory, write_json, write_text, write_with


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_round_trip_in_folders_that_did_not_exist(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "value.json"
    value = {"x": [1, 2.5, None, True, "ä"], "third": 1 / 3}
    write_json(path, value)
    assert read_json(path) == value
    assert names(path.parent) == ["value.json"]


def test_the_new_file_takes_the_place_of_the_old_at_once(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    write_text(path, "old")
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert path.read_text() == "old"
        assert temporary.parent == path.parent  # a rename is atomic only within a file system
    assert path.read_text() == "new"
    assert names(tmp_path) == ["file.txt"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_an_interruption_leaves_the_old_file_and_no_litter(tmp_path: Path, interruption: type[BaseException]) -> None:
    path = tmp_path / "file.txt"
    write_text(path, "old")

    def half(temporary: Path) -> None:
        temporary.write_text("hal")
        raise interruption

    with pytest.raises(interruption):
        write_with(path, half)
    assert path.read_text() == "old"
    assert names(tmp_path) == ["file.txt"]


def test_a_full_disk_is_a_file_problem_and_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file.txt"
    write_text(path, "old")

    def full(handle: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileProblem, match=r"file\.txt: cannot be written: No space left on device"):
        write_text(path, "new")
    assert path.read_text() == "old"
    assert names(tmp_path) == ["file.txt"]


def test_the_file_is_on_the_disk_before_it_takes_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, order = tmp_path / "file.txt", []
    real_fsync, real_replace = os.fsync, Path.replace
    monkeypatch.setattr(os, "fsync", lambda handle: (order.append("fsync"), real_fsync(handle)))
    monkeypatch.setattr(Path, "replace", lambda self, to: (order.append("rename"), real_replace(self, to)))
    write_text(path, "text")
    assert order == ["fsync", "rename", "fsync"]  # the contents; then the name, in the directory


def test_others_may_read_what_the_umask_lets_them(tmp_path: Path) -> None:
    # mkstemp makes files that only their owner can read
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "file.txt", "text")
    finally:
        os.umask(before)
    assert (tmp_path / "file.txt").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_nan_and_infinity_are_no_json(tmp_path: Path, bad: float) -> None:
    path = tmp_path / "value.json"
    write_json(path, {"x": 1.0})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"x": bad})
    assert json.loads(path.read_text()) == {"x": 1.0}
    assert names(tmp_path) == ["value.json"]


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileProblem, match="cannot be written"):
        write_text(tmp_path / "file" / "inside.txt", "text")
    for place in (tmp_path / "file", tmp_path / "file" / "inside"):
        with pytest.raises(FileProblem, match="not a writable directory"):
            writable_directory(place)


def test_writable_directory_is_made_and_left_empty(tmp_path: Path) -> None:
    folder = writable_directory(tmp_path / "a" / "b")
    assert folder == tmp_path / "a" / "b"
    assert names(folder) == []
    assert writable_directory(folder) == folder


def test_a_directory_that_refuses_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # permissions do not stop root, so the refusal is played
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("symdyn.io.files.tempfile.TemporaryFile", refuse)
    monkeypatch.setattr("symdyn.io.files.tempfile.mkstemp", refuse)
    with pytest.raises(FileProblem, match="Permission denied"):
        writable_directory(tmp_path)
    with pytest.raises(FileProblem, match="Permission denied"):
        write_text(tmp_path / "file.txt", "text")


def test_reading(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"none\.json: cannot be read: No such file"):
        read_json(tmp_path / "none.json")
    (tmp_path / "bad.json").write_text("{")
    with pytest.raises(FileProblem, match=r"bad\.json: is not valid JSON"):
        read_json(tmp_path / "bad.json")
    (tmp_path / "latin.json").write_bytes(b'{"x": "\xe4"}')
    with pytest.raises(FileProblem, match=r"latin\.json: is not valid JSON"):
        read_json(tmp_path / "latin.json")
