"""What a host says of the programs that it runs, beyond Python's own words."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import ClassVar

from . import imports
from .sandbox.amounts import MAX_FOLDER, MAX_FOLDER_FILES, MAX_MEMORY, MAX_PROCESSES
from .wire import steady


class Advice:
    """Words on a program for its author; a launcher takes a subclass, by "module:Class".

    Its methods are called in the program's own process, and decide nothing. This class says
    nothing.
    """

    MAX_FOLDER: ClassVar = MAX_FOLDER  # [bytes] what a program may use
    MAX_FOLDER_FILES: ClassVar = MAX_FOLDER_FILES
    MAX_MEMORY: ClassVar = MAX_MEMORY  # [bytes]
    MAX_PROCESSES: ClassVar = MAX_PROCESSES
    steady = staticmethod(steady)

    @staticmethod
    def hiding_file(error: BaseException) -> str:
        """Return the program's own file that hides the module of an ImportError; "" if none."""
        return imports.host.hiding_file(error)

    def begin(self) -> None:
        """Prepare the process, before any program runs in it."""

    def slips(self, source: bytes) -> list[str]:
        """Return sentences for stderr on a source that is about to run."""
        return []

    def unused_imports(self, source: bytes) -> list[str]:
        """Return the names that a source imports and never uses."""
        return []

    def wrong_field(self, message: object) -> str:
        """Say which field of a message that is published holds another type; "" if none does."""
        return ""

    def cause(self, error: BaseException) -> BaseException:
        """Return the exception to explain, where one exception has led to another."""
        return error

    def hint(self, error: BaseException) -> str:
        """Return what to do about an exception, in a sentence; "" if there is nothing to say."""
        return ""

    def account(self, error: BaseException, folder: Path) -> str:
        """Return an account of an exception, ahead of its traceback.

        `folder` is that of the program's modules.
        """
        return ""


given = Advice()


def use(name: str) -> None:
    """Take the advice of this name in this process; "" stands for none."""
    global given  # noqa: PLW0603
    if name:
        module, _, cls = name.partition(":")
        given = getattr(importlib.import_module(module), cls)()
