"""What never changes and may be shared wherever Drake would copy it."""

from typing import Self


class Shared:
    """A value that is its own deep copy.

    Drake copies all abstract state of a Diagram at every unrestricted update, hundreds
    of times a second; what is frozen need not be copied to stay as it is.
    """

    def __deepcopy__(self, memo: object) -> Self:
        """Returns itself, for it never changes."""
        return self
