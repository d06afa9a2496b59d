"""The little of SVG that the strips need: marks as text, numbers short."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


def number(value: float) -> str:
    """A coordinate: a tenth of a pixel is enough."""
    return f"{value:.1f}".removesuffix(".0")


def mark(tag: str, content: str = "", **attributes: str | float | None) -> str:
    """An element. An attribute's name has ``_`` for ``-``; floats are rounded, None is left out."""
    parts = [
        f' {name.replace("_", "-")}="{number(value) if isinstance(value, float) else escape(str(value))}"'
        for name, value in attributes.items()
        if value is not None
    ]
    return f"<{tag}{''.join(parts)}>{content}</{tag}>" if content else f"<{tag}{''.join(parts)}/>"


def text(x: float, y: float, content: str, **attributes: str) -> str:
    """Words with their base line at y."""
    return mark("text", escape(content), x=x, y=y, **attributes)


def line(points: Iterable[tuple[float, float]], **attributes: str | float) -> str:
    """A line through points."""
    path = " ".join(f"{number(x)},{number(y)}" for x, y in points)
    return mark("polyline", "", points=path, fill="none", stroke_linejoin="round", **attributes)


def picture(width: float, height: float, content: str, label: str) -> str:
    """A drawing as wide as its surroundings; ``label`` says to a screen reader what it shows."""
    return mark(
        "svg",
        content,
        viewBox=f"0 0 {number(width)} {number(height)}",
        width="100%",
        role="img",
        aria_label=label,
        font_size=11,
        font_family="system-ui, sans-serif",
        style="display:block",
    )
