"""Which network interface DDS uses, and whether that one can carry it."""

from __future__ import annotations

import fcntl
import os
import socket
import struct
from pathlib import Path

from symdyn.errors import InvalidValue, ResourceProblem

LOOPBACK = "lo"

ROBOT_DOMAIN = 0
"""The Go2's."""

SIMULATOR_DOMAIN = 1
"""Of simulated robots, as in unitree_mujoco: no mistake of an interface lets them meet a real one."""

MOST_DOMAINS = 232
"""DDS ports end there (DDSI 9.6.1.1)."""

_UP, _MULTICAST = 0x1, 0x1000  # IFF_UP, IFF_MULTICAST
_SIOCGIFADDR = 0x8915
_ANY = "CYCLONEDDS_URI"


def configuration(interface: str | None) -> str | None:
    """Cyclone DDS's configuration for an interface; None leaves it to CYCLONEDDS_URI, or to Cyclone DDS's own choice.

    Raises:
        InvalidValue: if there is no such interface.
        ResourceProblem: if it is down, has no IPv4 address, or carries no multicast.
    """
    if interface is None:
        return None
    _check(interface)
    general = f'<Interfaces><NetworkInterface name="{interface}"/></Interfaces>'
    discovery = ""
    if interface == LOOPBACK:  # which has no multicast: participants are asked one by one
        general += "<AllowMulticast>false</AllowMulticast>"
        discovery = '<ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="localhost"/></Peers>'
    return (
        f'<CycloneDDS><Domain Id="any"><General>{general}</General><Discovery>{discovery}</Discovery></Domain>'
        "</CycloneDDS>"
    )


def named(interface: str | None) -> str:
    """An interface in words."""
    if interface is not None:
        return f"interface {interface}"
    return f"the interface of {_ANY}" if os.environ.get(_ANY) else "the interface that Cyclone DDS chose"


def check_domain(domain: int) -> None:
    """Raises InvalidValue for a number that is no DDS domain."""
    if not 0 <= domain <= MOST_DOMAINS:
        raise InvalidValue("--domain", domain, f"a whole number from 0 (the robot's) to {MOST_DOMAINS}")


def _check(interface: str) -> None:
    there = [name for _, name in socket.if_nameindex()]
    if interface not in there:
        listed = ", ".join(f"{name} ({_address(name) or 'no address'})" for name in there)
        raise InvalidValue("--interface", interface, f"one of this computer's: {listed}")
    flags = int(Path(f"/sys/class/net/{interface}/flags").read_text(), 16)
    if not flags & _UP:
        raise ResourceProblem(f"The interface {interface} is down: sudo ip link set {interface} up")
    if _address(interface) is None:
        raise ResourceProblem(
            f"The interface {interface} has no IPv4 address. For the robot's cable: "
            f"sudo ip addr add 192.168.123.222/24 dev {interface}"
        )
    if interface != LOOPBACK and not flags & _MULTICAST:
        raise ResourceProblem(
            f"The interface {interface} carries no multicast, by which DDS finds the robot: "
            f"sudo ip link set {interface} multicast on"
        )


def _address(interface: str) -> str | None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            found = fcntl.ioctl(probe, _SIOCGIFADDR, struct.pack("256s", interface.encode()[:15]))
        except OSError:
            return None
    return socket.inet_ntoa(found[20:24])
