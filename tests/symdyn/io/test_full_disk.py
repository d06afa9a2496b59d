"""A full disk, or files that may not grow: every writer says so in one sentence and leaves nothing half done."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

LIMIT = 4096  # bytes a file may have

PYTHON = [sys.executable, "-B"]
"""An interpreter that keeps no compiled modules, which under the limit would be cut short and fail all later ones."""

WRITERS = {
    "json": """
from symdyn.io.files import write_json
write_json(here / "new", list(range(10_000)))
""",
    "text": """
from symdyn.io.files import write_text
write_text(here / "new", "x" * 10_000)
""",
    "figure": """
from symdyn.figures.plots import gait_diagram, save
from symdyn.gait.library import get
save(gait_diagram(get("trot"), 0.5), here / "new.png")
""",
    "gif": """
import numpy as np
from symdyn.figures.video import write_video
noise = np.random.default_rng(0).integers(0, 255, (5, 64, 64, 3)).astype("uint8")
write_video(here / "new.gif", iter(noise), 10)
""",
    "mp4": """
import numpy as np
from symdyn.figures.video import write_video
noise = np.random.default_rng(0).integers(0, 255, (50, 256, 256, 3)).astype("uint8")
write_video(here / "new.mp4", iter(noise), 10)
""",
    "families": """
from slip.families.cache import explored
from slip.families.store import save
from slip.model.parameters import REFERENCE
save(explored(REFERENCE), here / "new")
""",
    "calibration of feet": """
import numpy as np
from hardware.estimation.calibration import FootCalibration, FootSensor
foot = FootSensor(1.0, 0.0, 1.0, 10.0, 0.5)
FootCalibration((foot,) * 4, 10, "x" * 10_000).save(here / "new")
""",
    "policy": """
import shutil, onnx
from symdyn.io.files import write_with
from rl.pretrained import policy_path
model = onnx.load(policy_path())
write_with(here / "new.onnx", lambda temporary: onnx.save(model, temporary))
""",
}

RUN = """
import resource, sys
from pathlib import Path
from symdyn.errors import SymdynError
here = Path(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
try:
    exec(sys.argv[3])
except SymdynError as error:
    print("refused:", error)
"""


@pytest.mark.parametrize("writer", WRITERS)
def test_a_writer_says_it_in_one_sentence_and_leaves_nothing(writer, tmp_path):
    if writer == "mp4":
        pytest.importorskip("imageio_ffmpeg")
    command = [*PYTHON, "-c", RUN, str(tmp_path), str(LIMIT), WRITERS[writer]]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("refused:")]
    assert "cannot be written: " in line
    assert len(done.stdout.splitlines()) == 1
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def command(arguments: list[str], out: Path | str, limit: int | None = None) -> subprocess.CompletedProcess[str]:
    """``symdyn ARGUMENTS`` with its output in a file, under a limit on the size of files."""
    code = "import resource, sys; from symdyn_cli.main import main; "
    code += f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, resource.RLIM_INFINITY)); " if limit else ""
    code += "sys.exit(main(sys.argv[1:]))"
    with Path(out).open("w") as stream:
        return subprocess.run(
            [*PYTHON, "-c", code, *arguments], stdout=stream, stderr=subprocess.PIPE, text=True, check=False
        )


@pytest.mark.parametrize("arguments", [["gaits"], ["gaits", "--json"], ["robots"], ["gaits", "--observation"]])
def test_output_to_a_full_device_is_one_sentence_and_exit_code_2(arguments):
    done = command(arguments, "/dev/full")
    assert done.returncode == 2
    assert done.stderr == "symdyn: error: The output cannot be written: No space left on device.\n"


def test_a_command_whose_file_does_not_fit_is_one_sentence_and_exit_code_2(tmp_path):
    done = command(["gaits", "trot", "--figure", str(tmp_path / "trot.png")], tmp_path / "out.txt", LIMIT)
    assert done.returncode == 2
    assert done.stderr == f"symdyn: error: {tmp_path / 'trot.png'}: cannot be written: File too large.\n"
    assert not (tmp_path / "trot.png").exists()
