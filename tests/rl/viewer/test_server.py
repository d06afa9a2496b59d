"""The web server of the page: it listens where it was asked to, hands out the page and nothing else."""

from __future__ import annotations

import socket
import urllib.request

import pytest
import viser

from rl.viewer.window import server as viewer_server
from rl.viewer.window.server import is_loopback, serving, url
from symdyn.errors import InvalidValue, ResourceProblem


def answer(port: int, path: str) -> bytes:
    """What the server says to a request whose path no client tidies up."""
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        return connection.recv(1 << 16)


def test_the_page_is_there_until_the_block_ends_and_nothing_is_printed(capsys):
    with serving("127.0.0.1", 0) as server:
        port = server.get_port()
        assert port > 0
        with urllib.request.urlopen(url("127.0.0.1", port), timeout=30) as page:
            assert page.status == 200 and b"<html" in page.read().lower()
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", port), timeout=5)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    "path", ["/../../../../../../../../etc/hostname", "/..%2f..%2f..%2fetc/hostname", "/etc/passwd"]
)
def test_no_other_file_is_handed_out(path):
    with serving("127.0.0.1", 0) as server:
        assert answer(server.get_port(), path).startswith(b"HTTP/1.1 404")


def test_the_page_is_published_by_nobody():
    with serving("127.0.0.1", 0) as server:
        assert server.request_share_url() is None


def test_a_port_in_use():
    with serving("127.0.0.1", 0) as first:
        port = first.get_port()
        said = rf"Port {port} is in use.*--port {port + 1}"
        with pytest.raises(ResourceProblem, match=said), serving("127.0.0.1", port):
            pass


@pytest.mark.parametrize("port", [-1, 65536])
def test_no_port(port):
    with pytest.raises(InvalidValue, match="--port"), serving("127.0.0.1", port):
        pass


@pytest.mark.parametrize("host", ["no such host", "192.0.2.1", "ä" * 70])
def test_a_host_that_is_not_this_computer(host):
    with pytest.raises(InvalidValue, match="--host"), serving(host, 0):
        pass


def test_an_old_viser_is_refused(monkeypatch):
    monkeypatch.setattr(viewer_server.viser, "__version__", "0.2.23")
    with pytest.raises(ResourceProblem, match=r"viser 0\.2\.23 is too old"), serving("127.0.0.1", 0):
        pass
    assert viser.__version__ == "0.2.23"


@pytest.mark.parametrize(
    ("host", "loopback"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("127.8.8.8", True), ("0.0.0.0", False)],
)
def test_who_can_reach_it(host, loopback):
    assert is_loopback(host) == loopback


def test_addresses():
    assert url("127.0.0.1", 8080) == "http://127.0.0.1:8080"
    assert url("0.0.0.0", 1234) == "http://localhost:1234"
    assert url("::1", 80) == "http://[::1]:80"
