"""LCM URLs for tests that run at once without hearing each other."""

from __future__ import annotations

import socket

import pytest

from hardware.wire.link import check_url
from symdyn.errors import ResourceProblem


def multicast_url() -> str:
    """An URL on a port that nobody holds now. Skips the test where there is no multicast."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port = probe.getsockname()[1]
    url = f"udpm://239.255.76.67:{port}?ttl=0"
    try:
        check_url(url)
    except ResourceProblem as problem:
        pytest.skip(f"no multicast here: {problem}")
    return url
