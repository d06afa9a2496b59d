"""A participant on the robot's wire, and readers and writers of bytes.

cyclonedds' readers and writers make an object of every message, which takes 0.3 ms for a LowState. These pass the bytes
on, by the same calls of its C layer.
"""

# cyclonedds' C layer is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple
from uuid import UUID

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant, BuiltinTopicDcpsPublication
from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from hardware.dds.network import check_domain, configuration, named
from hardware.dds.version import check_version
from symdyn.errors import ResourceProblem

LOW_STATE, LOW_CMD = "rt/lowstate", "rt/lowcmd"
"""Topics of the robot's state and of its motors' commands (unitree_sdk2)."""

_MOST_ENDPOINTS = 1000
_ALL = SampleState.Any | ViewState.Any | InstanceState.Any


@dataclass(frozen=True)
class Publisher:
    """A writer of a topic, anywhere on the network.

    Attributes:
        key: of the writer, unique in the network.
        topic: its name.
        known_type: whether it announces the same type as this node's, or none.
        where: process and host in words.
    """

    key: UUID
    topic: str
    known_type: bool
    where: str


class Node:
    """A participant of a DDS domain.

    Args:
        interface: of the network, or None for Cyclone DDS's or CYCLONEDDS_URI's.
        domain: number.

    Attributes:
        interface: as given.
        domain: as given.
        own_writers: keys of the writers that were made here.

    Raises:
        InvalidValue: if the interface or the domain does not exist.
        ResourceProblem: if cyclonedds is another than was tested, or the network cannot be used.
    """

    def __init__(self, interface: str | None, domain: int) -> None:
        check_version()
        check_domain(domain)
        config = configuration(interface)
        try:
            self._domain = None if config is None else Domain(domain, config)
            self.participant = DomainParticipant(domain)
        except DDSException as error:
            raise ResourceProblem(f"DDS cannot be opened on {named(interface)} ({error.msg}).") from error
        self.interface, self.domain = interface, domain
        self.own_writers: set[UUID] = set()
        self._topics: dict[str, Topic] = {}
        self._publications = BuiltinDataReader(self.participant, BuiltinTopicDcpsPublication)
        self._participants = BuiltinDataReader(self.participant, BuiltinTopicDcpsParticipant)

    def topic(self, name: str, kind: type[IdlStruct]) -> Topic:
        """A topic of a type."""
        if name not in self._topics:
            self._topics[name] = Topic(self.participant, name, kind)
        return self._topics[name]

    def publishers(self, name: str) -> list[Publisher]:
        """Who writes on a topic now, of this or another type of that name; this node's own writers too."""
        own = self._topics[name].data_type.__idl__.get_type_id()
        others = self._others()
        found = []
        for one in self._publications.read(_MOST_ENDPOINTS):
            if one.topic_name == name and one.sample_info.instance_state == InstanceState.Alive:
                its = one.type_id
                known = its is None or (its.discriminator, its.value) == (own.discriminator, own.value)
                found.append(Publisher(one.key, name, known, others.get(one.participant_key, "an unknown process")))
        return found

    def participants(self) -> int:
        """How many others there are on this domain."""
        return len(self._others()) - 1

    def _others(self) -> dict[UUID, str]:
        return {
            one.key: _where(one.qos)
            for one in self._participants.read(_MOST_ENDPOINTS)
            if one.sample_info.instance_state == InstanceState.Alive
        }


class Sample(NamedTuple):
    """A message.

    Attributes:
        data: bytes.
        handle: number of its writer, of which :meth:`Reader.writer` tells the key.
        sent: when it was written, ns since 1970 by its writer's clock.
    """

    data: bytes
    handle: int
    sent: int


class Reader:
    """Bytes of a topic.

    Args:
        node: whose.
        topic: name.
        kind: type.
        depth: messages that are kept until they are taken; of more, the newest.
        ignore_own: leave out what this node writes itself.
    """

    def __init__(self, node: Node, topic: str, kind: type[IdlStruct], depth: int = 1, ignore_own: bool = False) -> None:
        self._node = node  # which ends with its last reference, and everything on it
        policies = [Policy.History.KeepLast(depth)]
        if ignore_own:
            policies.append(Policy.IgnoreLocal.Participant)
        self._reader = DataReader(node.participant, node.topic(topic, kind), Qos(*policies))
        self._depth = depth
        self._waiting = WaitSet(node.participant)
        self._new = ReadCondition(self._reader, _ALL)
        self._waiting.attach(self._new)
        self._writers: dict[int, UUID | None] = {}

    def wait(self, seconds: float) -> bool:
        """Until there is something to take, or the time is over; whether there is."""
        return self._waiting.wait(duration(microseconds=round(1e6 * seconds))) > 0

    def take(self) -> list[Sample]:
        """What has come since the last time."""
        taken = ddspy_take(self._reader._ref, _ALL, self._depth)
        if isinstance(taken, int):
            raise ResourceProblem(f"DDS has failed: {DDSException(taken).msg}.")
        return [Sample(data, info.publication_handle, info.source_timestamp) for data, info in taken if info.valid_data]

    def writer(self, handle: int) -> UUID | None:
        """The key of a writer, or None if it is not known any more."""
        if handle not in self._writers:
            found = self._reader.get_matched_publication_data(handle)
            self._writers[handle] = None if found is None else found.key
        return self._writers[handle]


class Writer:
    """Writes bytes to a topic.

    Args:
        node: whose.
        topic: name.
        kind: type.

    Attributes:
        key: unique in the network.
    """

    def __init__(self, node: Node, topic: str, kind: type[IdlStruct]) -> None:
        self._node = node  # as for a reader
        self._writer = DataWriter(node.participant, node.topic(topic, kind))
        self.key = self._writer.get_guid()
        node.own_writers.add(self.key)

    def write(self, data: bytes) -> None:
        """Send a message. Raises ResourceProblem if DDS does not take it."""
        code = ddspy_write(self._writer._ref, data)
        if code < 0:
            raise ResourceProblem(f"DDS has failed: {DDSException(code).msg}.")

    @property
    def readers(self) -> int:
        """How many read it now."""
        return len(self._writer.get_matched_subscriptions())


def _where(qos: Qos) -> str:
    told = {policy.key: policy.value for policy in qos if isinstance(policy, Policy.Property)}
    name, pid, host = (told.get(key) for key in ("__ProcessName", "__Pid", "__Hostname"))
    if name is None and pid is None:
        return "an unknown process"
    return f"{name or 'process'} ({pid or '?'}) on {host or 'an unknown host'}"
