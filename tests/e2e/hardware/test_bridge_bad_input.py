"""What ``symdyn bridge`` says to bad input."""

from __future__ import annotations

import pytest

from tests.e2e.command_in_process import symdyn
from tests.hardware.lcm_urls import multicast_url


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--interface", "eth77"), "--interface is 'eth77', but must be one of this computer's: lo (127.0.0.1)"),
        (("--domain", "233"), "--domain"),
        (("--domain", "-1"), "--domain"),
        (("--damping-kd", "0"), "--damping-kd"),
        (("--url", "udpm://127.0.0.1:7667"), "The LCM URL"),
    ],
)
def test_it_is_named_with_exit_code_2(arguments, said, tmp_path):
    done = symdyn("bridge", "--url", multicast_url(), *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


def test_help_says_what_damps_and_when(tmp_path):
    done = symdyn("bridge", "--help", cwd=tmp_path)
    assert done.returncode == 0
    told = " ".join(done.stdout.split())
    for words in ("Nothing is sent before the first targets", "After 100 ms without targets", "50 ms without"):
        assert words in told
