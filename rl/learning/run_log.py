"""What a run writes down as it goes: one JSON line an update, and TensorBoard."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from symdyn.errors import FileProblem
from symdyn.io.files import writable_directory, write_text

FILE = "progress.jsonl"


class RunLog:
    """Appends records to ``progress.jsonl`` and TensorBoard of a run directory.

    Args:
        run: the directory.
        resume_at: number of updates already in the checkpoint; later lines, of updates that will be done again, go.

    Raises:
        FileProblem: if nothing can be written there.
    """

    def __init__(self, run: Path, resume_at: int = 0) -> None:
        from torch.utils.tensorboard import SummaryWriter

        writable_directory(run)
        kept = [record for record in read(run) if record["iteration"] <= resume_at]
        write_text(run / FILE, "".join(json.dumps(record) + "\n" for record in kept))
        try:
            self._stream = (run / FILE).open("a", encoding="utf-8")
            self._writer = SummaryWriter(str(run), purge_step=resume_at + 1 if resume_at else None)
        except OSError as error:
            raise FileProblem(run / FILE, f"cannot be written: {error.strerror or error}.") from error

    def add(self, record: dict[str, Any]) -> None:
        """Write one update's record; ``iteration`` and ``samples`` are among its keys."""
        try:
            self._stream.write(json.dumps(record) + "\n")
            self._stream.flush()
        except OSError as error:
            raise FileProblem(FILE, f"cannot be written: {error.strerror or error}.") from error
        for key, value in record.items():
            if key not in ("iteration", "samples"):
                self._writer.add_scalar(key, value, record["iteration"])

    def sync(self) -> None:
        """Bring what was written onto the disk: called before a checkpoint, which must not be ahead of its log."""
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._writer.flush()

    def close(self) -> None:
        """Close both files."""
        self._stream.close()
        self._writer.close()


def read(run: Path) -> list[dict[str, Any]]:
    """The records of a run, oldest first; a last line cut short by a kill is left out."""
    path = run / FILE
    if not path.exists():
        return []
    records = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            records.append(json.loads(line))
        except ValueError:
            break
    return records
