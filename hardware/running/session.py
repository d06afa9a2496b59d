"""What a deployer's log says about itself at its head: enough to run the controller once more."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hardware.control.settings import Settings
from hardware.wire.messages import session_info_lcmt
from symdyn.errors import FileProblem
from symdyn.io.settings_data import plain, rebuild
from symdyn.robot.robot_file import DEFAULT_ROBOT

FORMAT_VERSION = 1


@dataclass(frozen=True)
class Session:
    """One run of the deployer.

    Attributes:
        policy: path of the policy file, as given.
        policy_sha256: of its content, in hexadecimal digits.
        settings: of the deployer.
        dry: whether nothing was sent.
        sender: who sent the targets: the wire's ``robot_id``.
        commit: of symdyn.
        robot: its name; logs from before they said so are of the default robot.
    """

    policy: str
    policy_sha256: str
    settings: Settings
    dry: bool
    sender: int
    commit: str
    robot: str = DEFAULT_ROBOT

    def message(self) -> session_info_lcmt:
        """For the log."""
        message = session_info_lcmt()
        message.json = json.dumps({"format_version": FORMAT_VERSION} | plain(self), allow_nan=False)
        return message

    @classmethod
    def of(cls, message: session_info_lcmt, origin: object) -> Session:
        """From the log.

        Raises:
            FileProblem: if it is of another version or not what this symdyn writes; ``origin`` says of what.
        """
        try:
            data: Any = json.loads(message.json)
            version = data.pop("format_version")
        except (ValueError, KeyError, AttributeError) as error:
            raise FileProblem(origin, f"has a header that cannot be read ({error}).") from error
        if version != FORMAT_VERSION:
            raise FileProblem(origin, f"has a header with format_version {version!r}, not {FORMAT_VERSION}.")
        return rebuild(cls, data, origin)


def sha256(path: Path) -> str:
    """Of a file's content. Raises FileProblem."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
