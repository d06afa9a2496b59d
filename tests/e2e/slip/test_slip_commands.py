"""``symdyn families`` and ``symdyn orbit`` as a user runs them. The families are explored once and then cached."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from slip.families.store import load
from slip.model.naming import FAMILIES
from slip.model.parameters import REFERENCE
from slip.orbits.orbit import residual
from symdyn_cli.main import main


def symdyn(*arguments: object) -> tuple[int, str, str]:
    """Exit code, output and errors of a command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(list(map(str, arguments)))
        except SystemExit as stop:  # the parser's own way out
            code = stop.code
    return int(code or 0), out.getvalue(), " ".join(err.getvalue().split())


@pytest.fixture(scope="module")
def families(slip_cache, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("slip") / "families"
    command = [sys.executable, "-m", "symdyn", "families", "--k", "10", "--ks", "20", "--J", "2", "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr
    assert "4.434062" in done.stdout
    return folder


class TestFamilies:
    def test_files(self, families):
        assert {path.name for path in families.iterdir()} == {"families.json", "families.npz", "families.png"}
        with Image.open(families / "families.png") as picture:
            assert min(picture.size) > 1000

    def test_json(self, families):
        read = json.loads((families / "families.json").read_text())
        assert set(read) >= {"branches", "junctions", "parameters", "tolerances"}
        for branch in read["branches"]:
            assert set(branch) >= {"name", "dx_min", "dx_max", "orbits"}
            assert branch["name"].rstrip("0123456789") in FAMILIES
        junctions = {(j["on"], j["to"]): j for j in read["junctions"]}
        assert set(read["junctions"][0]) >= {"on", "to", "pair", "dx", "T", "dphi"}
        pronk, bound = junctions["PK", "BG"], junctions["BG", "HG"]
        assert (pronk["dx"], pronk["T"]) == pytest.approx((4.434062, 1.364598), abs=1e-5)
        assert (bound["dx"], bound["T"], bound["dphi"]) == pytest.approx((4.506161, 1.352251, 0.028591), abs=1e-5)

    def test_the_nine_families(self, families):
        assert set(load(families).names) >= {"PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE"}

    def test_again_from_the_cache(self, families, tmp_path):
        code, out, _ = symdyn("families", "--out", tmp_path / "again")
        assert code == 0
        assert "BG" in out
        again, first = load(tmp_path / "again"), load(families)
        for a, b in zip(again.branches, first.branches, strict=True):
            assert np.array_equal(a.unknowns, b.unknowns)


class TestOrbit:
    def test_everything(self, families, tmp_path):
        flags = ("--animation.strides", 1, "--animation.seconds", 0.4, "--animation.width", 240)
        code, out, err = symdyn("orbit", "--family", "BG", "--speed", 5, "--out", tmp_path / "bound", *flags)
        assert code == 0, err
        assert {path.name for path in (tmp_path / "bound").iterdir()} == {"orbit.json", "orbit.png", "orbit.gif"}
        read = json.loads((tmp_path / "bound" / "orbit.json").read_text())
        unknowns = np.array(list(read["unknowns"].values()))
        assert unknowns[0] == pytest.approx(5.0, abs=1e-10)
        assert np.abs(residual(unknowns, REFERENCE)).max() < 1e-10
        assert read["independent_check"] < 1e-9
        assert set(read["symmetry"]["group"]) == {"e", "h", "f", "hf", "mt", "hmt", "fmt", "hfmt"}
        assert "K=<g_s> H=<g_s>" in out

    def test_without_animation_and_another_of_several(self, families, tmp_path):
        shown = load(families)
        inside = next(b for b in shown.branches if b.name == "HG").speeds
        speed = float(np.median(inside))
        code, out, err = symdyn("orbit", "--family", "HG", "--speed", speed, "--out", tmp_path, "--animate", "none")
        assert code == 0, err
        assert not (tmp_path / "orbit.gif").exists()
        assert "another lead" in out
        assert "not a gait" in out

    def test_one_branch_of_a_family(self, families, tmp_path):
        second = next((branch for branch in load(families).branches if branch.name == "HG2"), None)
        if second is None:
            pytest.skip("this family has one branch")
        speed = float(np.median(second.speeds))
        code, out, err = symdyn("orbit", "--family", "HG2", "--speed", speed, "--out", tmp_path, "--animate", "none")
        assert code == 0, err
        assert out.startswith("HG2, half-bound")

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (("--family", "XY", "--speed", 5), ("Unknown family 'XY'", "BG")),
            (("--family", "BG", "--speed", 1), ("--speed", "from 4.19", "15", "BG")),
            (("--family", "BG", "--speed", "nan"), ("--speed", "finite")),
            (("--family", "BG", "--speed", 5, "--which", 40), ("--which", "1")),
            (("--family", "BG", "--speed", 5, "--k", -1), ("stiffness", "> 0")),
            (("--family", "BG", "--speed", 5, "--robot", "dog"), ("Unknown robot 'dog'", "go2")),
            (("--family", "BG", "--speed", 5, "--animation.fps", 1), ("fps",)),
            (("--family", "BG", "--speed", 5, "--animate", "avi"), ("avi",)),
            (("--family", "BG", "--speed", "fast"), ("fast",)),
            (
                (
                    "--family",
                    "BG",
                ),
                ("speed",),
            ),
        ],
    )
    def test_refused(self, slip_cache, families, tmp_path, arguments, said):
        code, _, err = symdyn("orbit", *arguments, "--out", tmp_path / "out")
        assert code == 2
        assert all(words in err for words in said), err
        assert not list(tmp_path.iterdir())

    def test_a_family_that_the_model_does_not_have(self, families, tmp_path):
        missing = load(families).missing
        for family in sorted(set(missing) & {"TR", "PC"}):
            code, _, err = symdyn("orbit", "--family", family, "--speed", 1, "--out", tmp_path / "out")
            assert code == 2
            assert f"no family {family}" in err
            assert "Found: PK" in err

    @pytest.mark.parametrize("command", [("families",), ("orbit", "--family", "BG", "--speed", 5)])
    def test_unwritable(self, families, tmp_path, command):
        (tmp_path / "file").write_text("")
        code, _, err = symdyn(*command, "--out", tmp_path / "file" / "out")
        assert code == 2
        assert "file" in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--max-speed", 0), "--max-speed"),
        (("--J", "inf"), "pitch_inertia"),
        (("--robot", "dog"), "Unknown robot"),
        (("--kr", -2), "stiffness_ratio"),
    ],
)
def test_families_refuses(tmp_path, arguments, said):
    code, _, err = symdyn("families", *arguments, "--out", tmp_path / "out")
    assert code == 2
    assert said in err
    assert not list(tmp_path.iterdir())
