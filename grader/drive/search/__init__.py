"""Look for worlds in which a node fails (docs/search.md)."""

from grader.drive.search.finder import Found, Search, search
from grader.drive.search.worlds import Arena, arena_of

__all__ = ["Arena", "Found", "Search", "arena_of", "search"]
