"""Numbers that know how far they may be from the truth."""

from collections.abc import Iterator


class Bounded(float):
    """A float, with the largest distance of the exact number from it.

    >>> import genus
    >>> volume = genus.sphere(1).volume(relative=1e-3)
    >>> volume.low < 4.18879 < volume.high, volume.certified
    (True, True)
    >>> value, bound = volume
    """

    bound: float
    certified: bool

    def __new__(cls, value: float, bound: float, certified: bool = True) -> "Bounded":
        """Value, bound, and whether the bound is proven or estimated."""
        self = super().__new__(cls, value)
        self.bound = float(bound)
        self.certified = bool(certified)
        return self

    def __getnewargs__(self) -> tuple[float, float, bool]:  # type: ignore[override]
        return float(self), self.bound, self.certified

    @property
    def value(self) -> float:
        """The number alone."""
        return float(self)

    @property
    def low(self) -> float:
        """The exact number is not below this."""
        return float(self) - self.bound

    @property
    def high(self) -> float:
        """The exact number is not above this."""
        return float(self) + self.bound

    def __iter__(self) -> Iterator[float]:
        """Value and bound."""
        yield float(self)
        yield self.bound

    def __repr__(self) -> str:
        kind = "" if self.certified else ", certified=False"
        return f"Bounded({float(self)!r}, {self.bound:.3g}{kind})"
