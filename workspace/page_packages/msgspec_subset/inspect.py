"""What only errors in scenario files ask for; the page's have been read before."""


class UnionType:
    """A type."""


class NoneType:
    """A type."""
