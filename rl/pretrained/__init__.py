"""The policies that come with symdyn; ``README.md`` beside this file is their model card."""

from __future__ import annotations

from pathlib import Path

from symdyn.errors import UnknownName

DEFAULT = "go2"


def policy_path(name: str = DEFAULT) -> Path:
    """The policy file of that name.

    Raises:
        UnknownName: if none of that name is shipped.
    """
    files = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.onnx"))}
    try:
        return files[name]
    except KeyError:
        raise UnknownName("shipped policy", name, files) from None
