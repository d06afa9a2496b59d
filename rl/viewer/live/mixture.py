"""Which gait is chosen on the page: one of those that have a name, or a mixture of two."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import LIBRARY, Gait
from symdyn.policy.file import Policy


def gaits_of(policy: Policy) -> dict[str, Gait]:
    """Every gait that can be chosen by name: those that the policy was trained on come first."""
    return {**policy.gaits, **{name: gait for name, gait in LIBRARY.items() if name not in policy.gaits}}


@dataclass(frozen=True)
class Mixture:
    """A share of one gait in another.

    Attributes:
        first: name of the gait to which something is mixed.
        second: name of the gait that is mixed to it.
        weight: share of the second, in [0, 1]; 0 is the first alone.
    """

    first: str
    second: str
    weight: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.weight <= 1.0:
            raise InvalidValue("The weight of a gait mixture", self.weight, "in [0, 1]")

    def gait(self, known: Mapping[str, Gait]) -> Gait:
        """The gait that results; an unmixed one keeps its name.

        Raises:
            UnknownName: if ``known`` has not both.
        """
        for name in (self.first, self.second):
            if name not in known:
                raise UnknownName("gait", name, known)
        if self.weight == 0.0 or self.first == self.second:
            return known[self.first]
        if self.weight == 1.0:
            return known[self.second]
        return known[self.first].towards(known[self.second], self.weight)
