"""The one error that `sim` shows to a person."""


class InputError(Exception):
    """An input is wrong: one line that says where, what came, and what was expected.

    Its text is written for the person who wrote the file, and is shown without a traceback.
    """

    def __init__(self, line: str) -> None:
        super().__init__(" ".join(line.splitlines()))  # keys and file names may hold line breaks
