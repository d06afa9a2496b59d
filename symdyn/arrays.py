"""The type of arrays in functions that are written against the array API."""

from __future__ import annotations

from typing import Any

Array = Any
"""An array of any array-API namespace (numpy or torch here)."""
