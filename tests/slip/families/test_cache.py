import multiprocessing
import os
import subprocess
import sys
import time

import numpy as np
import pytest

from slip.cli.shipped import wanted
from slip.families import cache as diagram_cache
from slip.families.branch import Branch, Diagram, Junction
from slip.families.cache import SHIPPED, cache_folder, explored, key, solver_modules
from slip.families.continuation import StepConfig
from slip.families.explore import ExploreConfig
from slip.model.parameters import REFERENCE, SlipParameters
from tests.slip.orbits.stored_orbits import orbit


def diagram(parameters=REFERENCE) -> Diagram:
    unknowns = np.tile(orbit("BG").unknowns, (3, 1))
    branch = Branch("BG", parameters, unknowns, np.full((3, 11), 0.5 + 0j), np.zeros(3), ("a", "b"))
    return Diagram(parameters, (branch,), (Junction.at(unknowns[0], "PK", "BG", "both"),), {"TR": "none"})


@pytest.fixture
def explorations(monkeypatch, tmp_path):
    """What was explored; the cache is empty."""
    calls = []

    def explore(parameters, config, report):
        calls.append((parameters, config))
        report("BG", 3)
        return diagram(parameters)

    monkeypatch.setattr(diagram_cache, "explore", explore)
    monkeypatch.setattr(diagram_cache, "SHIPPED", tmp_path / "none")
    monkeypatch.setenv("SYMDYN_CACHE", str(tmp_path / "cache"))
    return calls


def test_second_time_from_the_cache(explorations):
    first, second = explored(REFERENCE), explored(REFERENCE)
    assert len(explorations) == 1
    assert second.names == first.names
    assert np.array_equal(second.branches[0].unknowns, first.branches[0].unknowns)
    assert second.junctions == first.junctions
    assert second.missing == first.missing


def test_other_parameters_and_other_settings_are_other_diagrams(explorations):
    explored(REFERENCE)
    explored(SlipParameters(stiffness=11.0))
    explored(REFERENCE, ExploreConfig(steps=StepConfig(max_speed=7.0)))
    explored(REFERENCE, ExploreConfig(trot=False))
    assert len(explorations) == 4


def test_processes_that_want_the_same_explore_it_once(monkeypatch, tmp_path):
    monkeypatch.setenv("SYMDYN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(diagram_cache, "SHIPPED", tmp_path / "none")
    began = multiprocessing.get_context("fork").Queue()

    def explore(parameters, config, report):
        began.put(os.getpid())
        time.sleep(0.5)
        return diagram(parameters)

    monkeypatch.setattr(diagram_cache, "explore", explore)
    processes = [multiprocessing.get_context("fork").Process(target=explored, args=(REFERENCE,)) for _ in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(60.0)
    assert [process.exitcode for process in processes] == [0, 0, 0]
    assert began.get(timeout=10.0) in {process.pid for process in processes}
    assert began.empty()


def test_without_cache(explorations, tmp_path):
    explored(REFERENCE, cache=False)
    explored(REFERENCE, cache=False)
    assert len(explorations) == 2
    assert not (tmp_path / "cache").exists()


def test_a_damaged_cache_is_explored_anew_and_mended(explorations, caplog):
    explored(REFERENCE)
    (cache_folder() / "families" / key(REFERENCE, ExploreConfig()) / "families.npz").write_bytes(b"nonsense")
    assert explored(REFERENCE).names == ("BG",)
    assert len(explorations) == 2
    assert "searched again" in caplog.text
    explored(REFERENCE)
    assert len(explorations) == 2


def test_a_cache_that_cannot_be_written_is_no_error(explorations, tmp_path, caplog):
    (tmp_path / "cache").write_text("a file")
    assert explored(REFERENCE).names == ("BG",)
    assert "not cached" in caplog.text


def test_the_report_is_passed_on(explorations):
    told = []
    explored(REFERENCE, report=lambda what, count: told.append((what, count)))
    assert told == [("BG", 3)]


def test_folder(monkeypatch, tmp_path):
    monkeypatch.delenv("SYMDYN_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "symdyn"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "symdyn"


def test_the_key_covers_every_module_that_explores():
    code = (
        "import slip.families.explore, sys; sys.stdout.write(' '.join(m for m in sys.modules if m.startswith('slip.')))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    files = {name for name in done.stdout.split() if name.count(".") == 2}  # the others are packages
    assert files == set(solver_modules())


def test_key_depends_on_the_solver(monkeypatch):
    before = key(REFERENCE, ExploreConfig())
    assert before == key(SlipParameters(), ExploreConfig())
    monkeypatch.setattr(diagram_cache, "_solver", lambda: "changed")
    assert key(REFERENCE, ExploreConfig()) != before


def test_what_comes_along_was_explored_by_this_solver():
    there = {folder.name for folder in SHIPPED.iterdir()}
    assert there == set(wanted()), "the solver has changed: python -m slip.cli.shipped"


def test_what_comes_along_is_taken_without_a_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("SYMDYN_CACHE", str(tmp_path / "cache"))
    for parameters, config in wanted().values():
        found = explored(parameters, config)
        assert found.parameters == parameters
        assert len(found.branches) > 2
    assert not (tmp_path / "cache").exists()
