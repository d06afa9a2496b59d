"""What ``symdyn deploy`` says to bad input, before any motor is told anything."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence
from pathlib import Path

import onnx
import pytest

from benchmarks.robot_processes import hearing, process
from rl.pretrained import policy_path
from symdyn.policy.file import METADATA_KEY
from tests.e2e.command_in_process import symdyn
from tests.e2e.hardware.waiting import wait_for
from tests.hardware.lcm_urls import multicast_url


class TestBadInput:
    """One sentence, exit code 2, before any motor is told anything."""

    @pytest.fixture
    def refused(self, tmp_path: Path) -> Callable[..., None]:
        def check(arguments: Sequence[object], *words: str) -> None:
            done = symdyn("deploy", *arguments, cwd=tmp_path)
            assert done.returncode == 2, done.stdout
            assert done.stderr.startswith("symdyn: error: ")
            assert len(done.stderr.splitlines()) == 1
            for word in words:
                assert word in done.stderr

        return check

    @pytest.mark.parametrize("url", ["udp://1.2.3.4:5", "udpm://10.0.0.1:7667", "udpm://239.255.76.67", "nonsense"])
    def test_url(self, url: str, refused: Callable[..., None]) -> None:
        refused([policy_path(), "--url", url], "The LCM URL", "udpm://")

    def test_policy_that_is_missing_broken_or_of_another_robot(
        self, tmp_path: Path, refused: Callable[..., None]
    ) -> None:
        refused([tmp_path / "none.onnx"], "none.onnx", "cannot be read")
        broken = tmp_path / "broken.onnx"
        broken.write_bytes(policy_path().read_bytes()[:5000])
        refused([broken], "cannot be loaded as an ONNX model")
        model = onnx.load(policy_path())
        (entry,) = (e for e in model.metadata_props if e.key == METADATA_KEY)
        entry.value = entry.value.replace("FL_hip_joint", "front_left_hip")
        onnx.save(model, tmp_path / "other.onnx")
        refused([tmp_path / "other.onnx", "--url", multicast_url()], "not have the joints of go2", "front_left_hip")

    def test_log_that_cannot_be_written(self, tmp_path: Path, refused: Callable[..., None]) -> None:
        log = tmp_path / "run.lcmlog"
        log.write_bytes(b"precious")
        refused([policy_path(), "--url", multicast_url(), "--log", log], str(log))
        assert log.read_bytes() == b"precious"
        refused([policy_path(), "--url", multicast_url(), "--log", "/dev/null/run.lcmlog"], "/dev/null")

    def test_port_in_use(self, refused: Callable[..., None]) -> None:
        url = multicast_url()
        port = int(url.rsplit(":", 1)[1].split("?")[0])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("", port))
            refused([policy_path(), "--url", url], f"port {port}", "--url")

    def test_another_deployer_at_work(self, refused: Callable[..., None]) -> None:
        url = multicast_url()
        with process("robot-sim", "--url", url, "--fault", "second_deployer", "--fault-at", 0.1, "--fault-for", 60.0):
            with hearing(url) as ear:
                wait_for(lambda: len(ear.targets) > 3, "the other deployer")
            refused([policy_path(), "--url", url], "Another deployer")

    def test_keyboard_without_a_terminal(self, refused: Callable[..., None]) -> None:
        refused([policy_path(), "--url", multicast_url(), "--keyboard"], "terminal")

    def test_settings(self, refused: Callable[..., None]) -> None:
        refused([policy_path(), "--safety.tilt", "-1"], "safety.tilt", "> 0")
        refused([policy_path(), "--joystick.buttons.A", "amble"], "amble", "trot")
