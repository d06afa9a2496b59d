"""Settings of training run and deployer: flag, default, what presets change, meaning; from the dataclasses."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import griffe

from hardware.control.settings import Settings
from rl.learning.config import TrainConfig
from rl.learning.presets import PRESETS
from symdyn.io.markdown import table

_PAPER = "paper"


def pages() -> dict[str, str]:
    """Markdown by path."""
    return {"reference/settings.md": _training(), "reference/deployer.md": _deployer()}


def _deployer() -> str:
    lines = [
        "# Settings of the deployer",
        "",
        "Flags of [`symdyn deploy`](commands/deploy.md), and what they are when left out.",
        *_section(Settings, {"default": Settings()}, ()),
    ]
    return "\n".join(lines) + "\n"


def _training() -> str:
    lines = [
        "# Settings of a training run",
        "",
        "Every setting is a flag of [`symdyn train`](commands/train.md), and the file `RUN/config.yaml` holds them all",
        "before a run begins. `--preset` chooses where they start from, any flag changes one of them:",
        "",
        "```sh",
        ".venv/bin/symdyn train --preset cpu --env.rewards.temporal 0.3 --ppo.epochs 4 --out runs/mine",
        "```",
        "",
        f"Presets: {', '.join(f'`{name}`' for name in PRESETS)}. `cpu` is the default of the command, `{_PAPER}` is",
        "the paper. Why they differ is told in [what is the paper's, and what is ours](../method.md). The second",
        f"column is the value of `{_PAPER}`, the third what other presets change it to.",
    ]
    presets = {name: PRESETS[name]() for name in sorted(PRESETS, key=lambda name: name != _PAPER)}
    lines += _section(TrainConfig, presets, ())
    return "\n".join(lines) + "\n"


def _section(cls: type, presets: dict[str, Any], path: tuple[str, ...], repeated: bool = False) -> list[str]:
    """Heading, table and the sections below it.

    Args:
        cls: a configuration class.
        presets: its value in every preset; the first is the one that the others are compared with.
        path: where it stands in TrainConfig.
        repeated: whether the class has a section already, so that only what the presets change is shown.
    """
    base = next(iter(presets))
    plain = [f.name for f in fields(cls) if not is_dataclass(getattr(presets[base], f.name))]
    nested = [f.name for f in fields(cls) if f.name not in plain]
    code = f"[{cls.__name__}][{cls.__module__}.{cls.__name__}]"
    summary, meanings = documentation(cls)
    lines = []
    if repeated:
        plain = [name for name in plain if _changes(presets, name)]
        summary = f"The settings of {code} once more, where presets change them."
    if plain:
        heading = f"{'#' * min(1 + max(len(path), 1), 4)} {'.'.join(path) or 'In general'}"
        lines += ["", heading, "", summary if repeated else f"{summary} ({code})", ""]
        lines += _table(plain, presets, path, meanings)
    for name in nested:
        inner = {preset: getattr(value, name) for preset, value in presets.items()}
        lines += _section(type(inner[base]), inner, (*path, name), repeated=name == "final")
    return lines


def _table(names: list[str], presets: dict[str, Any], path: tuple[str, ...], meanings: dict[str, str]) -> list[str]:
    """Flag, value of the first preset, what others change it to (where there are others), meaning."""
    base, compared, rows = next(iter(presets)), len(presets) > 1, []
    for name in names:
        flag = f"`--{'.'.join((*path, name)).replace('_', '-')}`"
        changes = [f"{preset}: {_text(value)}" for preset, value in _changes(presets, name).items()]
        meaning = meanings.get(name, "").replace("|", "\\|").replace("``", "`")
        rows.append([flag, _text(getattr(presets[base], name)), *(["<br>".join(changes)] * compared), meaning])
    return table(["flag", base, *(["changed by presets"] * compared), "meaning"], rows)


def _changes(presets: dict[str, Any], name: str) -> dict[str, Any]:
    """The value in the presets where it is not that of the first, equal ones together under their names."""
    first = getattr(next(iter(presets.values())), name)
    grouped: dict[str, list[str]] = {}
    values = {}
    for preset, config in presets.items():
        value = getattr(config, name)
        if value != first and name != "preset":
            grouped.setdefault(repr(value), []).append(preset)
            values[repr(value)] = value
    return {", ".join(names): values[key] for key, names in grouped.items()}


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_text, value)) or "(empty)"
    if isinstance(value, float):
        return f"{value:g}"
    return str(value)


def documentation(cls: type) -> tuple[str, dict[str, str]]:
    """First paragraph of a class's docstring, and the meaning of each attribute."""
    summary, meanings = "", {}
    for section in griffe.Docstring(cls.__doc__ or "", parser="google").parse():
        if section.kind is griffe.DocstringSectionKind.text and not summary:
            summary = " ".join(section.value.split())
        elif section.kind is griffe.DocstringSectionKind.attributes:
            meanings = {item.name: " ".join(item.description.split()) for item in section.value}
    return summary, meanings
