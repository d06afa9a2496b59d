"""A recording comes back from its file as it was, and a damaged file is refused in one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.analysis.recording import Recording
from symdyn.errors import FileProblem
from symdyn.gait.library import get
from tests.symdyn.analysis.synthetic import recording


@pytest.mark.parametrize("name", ["run.npz", "run", "run.log"])
def test_comes_back_as_it_was_under_the_name_it_was_given(tmp_path: Path, name: str) -> None:
    original = recording(get("bound"), 0.5, seconds=0.5)
    original.save(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    loaded = Recording.load(tmp_path / name)
    for field, value in vars(original).items():
        np.testing.assert_array_equal(getattr(loaded, field), value)
        assert type(getattr(loaded, field)) is type(value)


def test_between_takes_the_samples_of_a_span_and_keeps_the_rest() -> None:
    whole = recording(get("trot"), 1.0, seconds=1.0, dt=0.01)
    part = whole.between(0.25, 0.5)
    assert len(part.time) == 25
    np.testing.assert_array_equal(part.stride_phase, whole.stride_phase[25:50])
    assert (part.dt, part.mass) == (whole.dt, whole.mass)


@pytest.mark.parametrize("spoil", [lambda b: b"", lambda b: b[: len(b) // 2], lambda b: b"trot", lambda b: b[::-1]])
def test_a_damaged_file_is_refused(tmp_path: Path, spoil) -> None:
    path = tmp_path / "run.npz"
    recording(get("trot"), 1.0, seconds=0.1).save(path)
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(FileProblem, match=r"run\.npz"):
        Recording.load(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="nowhere"):
        Recording.load(tmp_path / "nowhere.npz")


def test_a_file_of_before_a_field_was_added_says_which(tmp_path: Path) -> None:
    path = tmp_path / "old.npz"
    values = vars(recording(get("trot"), 1.0, seconds=0.1))
    np.savez(path, **{name: value for name, value in values.items() if name != "base_quat_w"})
    with pytest.raises(FileProblem, match=r"old\.npz: .*lacks base_quat_w\); record it again"):
        Recording.load(path)
