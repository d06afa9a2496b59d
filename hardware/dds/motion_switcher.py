"""The robot's built-in motion service, asked and told through its motion switcher.

Two topics: requests with the number of a function and a parameter in JSON, responses with the number of the request
(unitree_sdk2, MotionSwitcherClient). While a service is active it commands the motors, too.
"""

from __future__ import annotations

import json
import time
from typing import Any

from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from hardware.dds.node import Node
from hardware.dds.types import (
    Request,
    RequestHeader,
    RequestIdentity,
    RequestLease,
    RequestPolicy,
    Response,
    ResponseHeader,
    ResponseStatus,
)
from symdyn.errors import ResourceProblem

REQUESTS, RESPONSES = "rt/api/motion_switcher/request", "rt/api/motion_switcher/response"
CHECK_MODE, RELEASE_MODE = 1001, 1003
"""Functions (unitree_sdk2, motion_switcher_api)."""

UNKNOWN_FUNCTION = 3203
"""Code of a response (unitree_sdk2, RPC_ERR_SERVER_API_NOT_IMPL)."""

_NOTHING: Any = ()
_ANSWER_S = 1.0
_TRIES = 5
_POLL_S = 0.02
_KEEP = "A simulator may have no motion service: --keep-service skips this step."


class MotionSwitcher:
    """Asks and tells it.

    Args:
        node: on the robot's network.
    """

    def __init__(self, node: Node) -> None:
        self._node = node  # which ends with its last reference
        self._writer = DataWriter(node.participant, node.topic(REQUESTS, Request))
        self._reader = DataReader(node.participant, node.topic(RESPONSES, Response))
        self._number = time.monotonic_ns()

    def active(self) -> str:
        """Name of the active service, or "". Raises ResourceProblem if there is no answer."""
        response = self._ask(CHECK_MODE)
        try:
            return str(json.loads(response)["name"] or "")
        except (ValueError, KeyError, TypeError) as error:
            raise ResourceProblem(f"The robot's motion switcher answered {response!r}.") from error

    def release(self) -> str:
        """Release the active service and see that none is active any more.

        Returns:
            the name of the service that was active, or "".

        Raises:
            ResourceProblem: if there is no answer, or a service stays active.
        """
        first = name = self.active()
        for _ in range(_TRIES):
            if not name:
                return first
            self._ask(RELEASE_MODE)
            time.sleep(_ANSWER_S / _TRIES)
            name = self.active()
        raise ResourceProblem(
            f"The robot's motion service {name!r} stays active after {_TRIES} releases. End it with the robot's app, "
            "which must say that no motion mode is active, and start again."
        )

    def _ask(self, function: int) -> str:
        for _ in range(_TRIES):
            self._number += 1
            header = RequestHeader(RequestIdentity(self._number, function), RequestLease(0), RequestPolicy(0, False))
            self._writer.write(Request(header, "{}", _NOTHING))
            response = self._answer(self._number)
            if response is not None:
                if response.header.status.code != 0:
                    raise ResourceProblem(
                        f"The robot's motion switcher refused function {function} with code "
                        f"{response.header.status.code}. {_KEEP}"
                    )
                return response.data
        raise ResourceProblem(
            f"The robot's motion switcher gives no answer on {REQUESTS}, so it is unknown whether the robot's own "
            f"controller is off. {_KEEP}"
        )

    def _answer(self, number: int) -> Response | None:
        until = time.monotonic() + _ANSWER_S
        while time.monotonic() < until:
            for response in self._reader.take(16):
                if isinstance(response, Response) and response.header.identity.id == number:
                    return response
            time.sleep(_POLL_S)
        return None


class SimulatedMotionSwitcher:
    """The other end, for the simulated robot. Call :meth:`answer` again and again.

    Args:
        node: the robot's.
        service: name of the service that is active at first, or "".

    Attributes:
        service: the active one, or "".
    """

    def __init__(self, node: Node, service: str) -> None:
        self._node = node  # which ends with its last reference
        self._reader = DataReader(node.participant, node.topic(REQUESTS, Request))
        self._writer = DataWriter(node.participant, node.topic(RESPONSES, Response))
        self.service = service

    def answer(self) -> None:
        """Answer the requests that have come."""
        for request in self._reader.take(16):
            if not isinstance(request, Request):
                continue
            identity, code, data = request.header.identity, 0, ""
            match identity.api_id:
                case int(function) if function == CHECK_MODE:
                    data = json.dumps({"form": "0", "name": self.service})
                case int(function) if function == RELEASE_MODE:
                    self.service = ""
                case _:
                    code = UNKNOWN_FUNCTION
            self._writer.write(Response(ResponseHeader(identity, ResponseStatus(code)), data, _NOTHING))
