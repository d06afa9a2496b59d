"""What ``symdyn play`` says to bad input."""

from __future__ import annotations

import socket

import pytest

from tests.e2e.command_in_process import symdyn


def test_port_in_use(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = symdyn("play", "--port", port, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith(f"symdyn: error: Port {port} is in use")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("missing.onnx",), "missing.onnx: cannot be read"),
        (("text.onnx",), "text.onnx: cannot be loaded as an ONNX model"),
        (("--port", "70000"), "--port is 70000, but must be"),
        (("--host", "no.such.host.invalid"), "--host is"),
        (("--seed", "-1"), "--seed is -1, but must be"),
        (("--robot-sim", "tcp://somewhere:1"), "The LCM URL is"),
        (("missing.onnx", "--robot-sim"), "POLICY is"),
    ],
)
def test_bad_input_is_one_sentence(arguments, said, tmp_path):
    (tmp_path / "text.onnx").write_text("no network", encoding="utf-8")
    done = symdyn("play", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr and done.stderr.count("\n") == 1, done.stderr
