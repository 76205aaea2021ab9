"""What zwidth refuses."""


class ZwidthError(ValueError):
    """Something that zwidth refuses: its text says where, what, and what to do.

    The parts that a program may want are beside it.
    """

    file: str | None
    """The file, where it is about one."""
    column: str | None
    """The column, argument or key, where it is about one."""
    row: int | None
    """The row, from 1, where it is about one."""
    remedy: str | None
    """What to do about it, where the text does not say it in one with what is wrong."""

    def __init__(
        self,
        text: str,
        file: str | None = None,
        column: str | None = None,
        row: int | None = None,
        remedy: str | None = None,
    ) -> None:
        super().__init__(text)
        self.file = file
        self.column = column
        self.row = row
        self.remedy = remedy
