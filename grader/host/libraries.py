"""Make libraries seem not installed, for nodes that have to live without them."""

from __future__ import annotations

import sys
from collections.abc import Collection
from typing import Any


def hide(names: Collection[str]) -> None:
    """Let imports of these top-level modules fail from now on, as if they were not installed."""
    if not names:
        return
    hidden = frozenset(names)
    for name in list(sys.modules):  # the fork server may have imported them already
        if name.partition(".")[0] in hidden:
            del sys.modules[name]
    sys.meta_path[:] = [_Blind(finder, hidden) for finder in sys.meta_path]


class _Blind:
    """A finder of modules that does not find some."""

    def __init__(self, finder: Any, hidden: frozenset[str]) -> None:
        self._finder, self._hidden = finder, hidden

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        """Return the module's spec; None if there is none, or none to be seen."""
        if name.partition(".")[0] in self._hidden:
            return None
        return self._finder.find_spec(name, path, target)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._finder, name)
