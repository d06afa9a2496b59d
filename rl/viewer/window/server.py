"""The web server of the page: viser's, told to be quiet, and only where it was asked to be."""

from __future__ import annotations

import contextlib
import errno
import io
import ipaddress
import socket
import time
from collections.abc import Iterator

import viser

from symdyn.errors import InvalidValue, ResourceProblem

_OLDEST_VISER = (1, 1)
"""Earlier ones hand out every file of this computer to whoever reaches the port (path traversal)."""


_GOODBYE_S = 0.2  # after which the thread that serves has said that it ends


class _Server(viser.ViserServer):
    def request_share_url(self, verbose: bool = True) -> str | None:
        # viser's way to publish a page through a server of its authors; any visitor could ask for it
        return None


@contextlib.contextmanager
def serving(host: str, port: int) -> Iterator[viser.ViserServer]:
    """A server that listens until the block ends.

    Args:
        host: name or address of this computer under which it shall be reached.
        port: from 0 to 65535; 0 takes a free one.

    Raises:
        InvalidValue: for a port that is none, or a host that is not this computer.
        ResourceProblem: if the port is in use or not allowed, or viser is too old.
    """
    version = tuple(int(part) for part in viser.__version__.split(".")[:2])
    if version < _OLDEST_VISER:
        raise ResourceProblem(
            f"viser {viser.__version__} is too old: it would serve any file of this computer to anyone who can reach "
            "the page's port. Install a newer one: pip install 'viser>=1.1'."
        )
    port = _free_port(host, port)
    with contextlib.redirect_stdout(io.StringIO()):  # it prints a box with its own name in it
        server = _Server(host=host, port=port, verbose=False)
    try:
        if server.get_port() != port:  # somebody was faster
            raise ResourceProblem(_in_use(port))
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
            time.sleep(_GOODBYE_S)


def is_loopback(host: str) -> bool:
    """Whether only programs of this computer reach a host's ports."""
    addresses = {info[4][0] for info in socket.getaddrinfo(host, None)}
    return all(ipaddress.ip_address(address).is_loopback for address in addresses)


def url(host: str, port: int) -> str:
    """What to type into a browser of this computer."""
    if host in ("0.0.0.0", "::", ""):
        host = "localhost"
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _free_port(host: str, port: int) -> int:
    # viser would take the next free port instead, and wait for ever if the host is wrong
    if not 0 <= port <= 65535:
        raise InvalidValue("--port", port, "from 0 to 65535; 0 chooses a free one")
    try:
        infos = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, UnicodeError) as error:
        raise InvalidValue("--host", host, "a name or address of this computer") from error
    family, kind, protocol, _, address = infos[0]
    with socket.socket(family, kind, protocol) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(address)
        except PermissionError as error:
            raise ResourceProblem(
                f"You have no permission for port {port}; choose one from 1024 up with --port."
            ) from error
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise ResourceProblem(_in_use(port)) from error
            raise InvalidValue("--host", host, "a name or address of this computer") from error
        return probe.getsockname()[1]


def _in_use(port: int) -> str:
    another = port + 1 if port < 65535 else port - 1
    return f"Port {port} is in use, perhaps by another symdyn play; choose another one: --port {another}."
