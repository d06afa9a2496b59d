"""The table of trials: what is written is read, and what is wrong is named by line and column."""

from __future__ import annotations

import contextlib
import hashlib
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.analysis import trials
from symdyn.analysis.trials import Trial
from symdyn.errors import FileProblem

HEAD = "v,T,beta,cost_of_transport,tracking_error,weight"
GOOD = "0.5,0.4,0.5,0.8,0.05,1"


def table(folder: Path, *lines: str) -> Path:
    path = folder / "trials.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_required_columns_are_enough(tmp_path: Path) -> None:
    (trial,) = trials.read(table(tmp_path, HEAD, GOOD))
    assert trial == Trial(v=0.5, T=0.4, beta=0.5, cost_of_transport=0.8, tracking_error=0.05, weight=1.0)


def test_columns_in_any_order_with_others_between_and_the_papers_spelling(tmp_path: Path) -> None:
    head = "operator,Weight,tracking error,cost of transport,BETA,t,V"
    (trial,) = trials.read(table(tmp_path, head, "me,1,0.05,0.8,0.5,0.4,0.5"))
    assert (trial.v, trial.T, trial.cost_of_transport, trial.weight) == (0.5, 0.4, 0.8, 1.0)
    (trial,) = trials.read(table(tmp_path, "v,T,beta,CoT,tracking_error,weight", GOOD))
    assert trial.cost_of_transport == 0.8


def test_an_empty_cell_is_no_number(tmp_path: Path) -> None:
    (trial,) = trials.read(table(tmp_path, HEAD + ",fell", "0.5,0.4,0.5,,,0,1"))
    assert (trial.cost_of_transport, trial.tracking_error, trial.fell) == (None, None, True)


def test_empty_lines_a_byte_order_mark_and_windows_line_ends(tmp_path: Path) -> None:
    path = tmp_path / "trials.csv"
    path.write_bytes(b"\xef\xbb\xbf" + f"{HEAD}\r\n\r\n{GOOD}\r\n,,,,,\r\n".encode())
    assert len(trials.read(path)) == 1


numbers = st.floats(1e-6, 1e6)
optional = st.none() | numbers


@settings(max_examples=30)
@given(
    st.lists(
        st.builds(
            Trial,
            v=st.floats(-5.0, 5.0), T=numbers, beta=st.floats(0.01, 0.99), cost_of_transport=optional,
            tracking_error=optional, weight=st.floats(0.0, 1.0), gait=st.sampled_from(["", "trot", "rotary_gallop"]),
            seed=st.none() | st.integers(0, 2**31), fell=st.booleans(), gc_stance=optional, gait_identity=optional,
            samples=st.none() | st.integers(0, 10**6), leg_length=optional,
        ),
        min_size=1,
        max_size=5,
    )
)  # fmt: skip
def test_round_trip_is_exact(tmp_path_factory: pytest.TempPathFactory, rows: list[Trial]) -> None:
    folder = tmp_path_factory.getbasetemp()
    records = [{**row.as_dict(), "extra": 1} for row in rows]
    (folder / "round.csv").write_text(trials.as_csv(records))
    (folder / "round.json").write_text(json.dumps({"format_version": 1, "rows": records}))
    assert trials.read(folder / "round.csv") == rows
    assert trials.read(folder / "round.json") == rows


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ((HEAD, GOOD, GOOD.replace("0.4", "soon")), "line 3, column 'T': 'soon' is not > 0 (s)"),
        ((HEAD, GOOD.replace("0.4", "-0.4")), "line 2, column 'T': '-0.4' is not > 0"),
        ((HEAD, GOOD.replace("0.4", "")), "line 2, column 'T': '' is not > 0"),
        ((HEAD, GOOD.replace("0.4", "nan")), "column 'T': 'nan'"),
        ((HEAD, "", GOOD.replace("0.4,0.5", "0.4,1.5")), "line 3, column 'beta': '1.5' is not in (0, 1)"),
        ((HEAD, GOOD.replace("0.5,0.4", "inf,0.4")), "column 'v': 'inf' is not a finite number"),
        ((HEAD, GOOD.replace("0.8", "-1")), "column 'cost_of_transport': '-1' is not > 0, or empty"),
        ((HEAD, GOOD.replace("0.05", "-0.05")), "column 'tracking_error': '-0.05'"),
        ((HEAD, GOOD[:-1] + "-1"), "column 'weight': '-1' is not >= 0"),
        ((HEAD + ",fell", GOOD + ",perhaps"), "column 'fell': 'perhaps' is not 0 or 1"),
        ((HEAD + ",seed", GOOD + ",1.5"), "column 'seed': '1.5' is not a whole number"),
        ((HEAD, GOOD + ",7"), "line 2 has 7 cells, but the header has 6"),
        ((HEAD, GOOD.rsplit(",", 1)[0]), "line 2 has 5 cells, but the header has 6"),
        ((HEAD.replace(",beta", ""), GOOD), "lacks the columns beta; it has v, T, cost"),
        ((HEAD + ",v", GOOD + ",1"), "has the column 'v' twice"),
        ((HEAD + ",cot", GOOD + ",1"), "has the column 'cost_of_transport' twice"),
        ((HEAD,), "contains no trials"),
        (("",), "lacks the columns v, T"),
        ((HEAD, '0.5,"0.4'), "is not valid CSV"),
    ],
)
def test_bad_table(tmp_path: Path, lines: tuple[str, ...], said: str) -> None:
    with pytest.raises(FileProblem) as error:
        trials.read(table(tmp_path, *lines))
    assert str(error.value).startswith(str(tmp_path / "trials.csv"))
    assert said in str(error.value)


def row(**change: Any) -> dict[str, Any]:
    return Trial(0.5, 0.4, 0.5, 0.8, 0.05, 1.0).as_dict() | change


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ([], "not a table of trials with format_version 1"),
        ({"format_version": 2, "rows": []}, "not a table of trials with format_version 1"),
        ({"format_version": 1}, "no list of rows"),
        ({"format_version": 1, "rows": [row(), 7]}, "row 2 is 7"),
        ({"format_version": 1, "rows": [row(T=True)]}, "row 1, column 'T': True is not"),
        ({"format_version": 1, "rows": [row(T=[1])]}, "row 1, column 'T': [1] is not"),
        ({"format_version": 1, "rows": [row(v=10**400)]}, "row 1, column 'v'"),
        ({"format_version": 1, "rows": [row(gait=3)]}, "row 1, column 'gait': 3 is not text"),
        ({"format_version": 1, "rows": [{"v": 1.0}]}, "lacks the columns T, beta"),
        ({"format_version": 1, "rows": []}, "contains no trials"),
    ],
)
def test_bad_json(tmp_path: Path, document: Any, said: str) -> None:
    (tmp_path / "trials.json").write_text(json.dumps(document))
    with pytest.raises(FileProblem) as error:
        trials.read(tmp_path / "trials.json")
    assert said in str(error.value)


def test_provenance_names_the_table_and_where_json_says_it_the_policy(tmp_path: Path) -> None:
    path = table(tmp_path, HEAD, GOOD)
    found = trials.provenance(path)
    assert set(found) == {"table", "table_sha256"}
    assert found["table_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    settings_of = {"policy": "a.onnx", "policy_sha256": "0", "sweep": {}}
    path = tmp_path / "trials.json"
    path.write_text(json.dumps({"format_version": 1, "settings": settings_of, "rows": [row()]}))
    assert trials.provenance(path)["policy"] == "a.onnx" and "sweep" not in trials.provenance(path)
    with pytest.raises(FileProblem, match="cannot be read"):
        trials.provenance(tmp_path / "none.csv")


def test_no_table(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="cannot be read: No such file"):
        trials.read(tmp_path / "none.csv")
    with pytest.raises(FileProblem, match="cannot be read: Is a directory"):
        trials.read(tmp_path)
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(FileProblem, match="is not a text file"):
        trials.read(tmp_path / "picture.csv")


@settings(max_examples=200)
@given(st.text(max_size=300) | st.binary(max_size=300))
def test_whatever_a_file_holds_it_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, content: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content if isinstance(content, bytes) else f"{HEAD}\n{content}".encode("utf-8", "replace"))
    with contextlib.suppress(FileProblem):
        trials.read(path)
