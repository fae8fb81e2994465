"""What a lookup may raise, by the names of tf2."""


class TransformException(Exception):
    """A transform is not to be had."""


class LookupException(TransformException):
    """A frame is not known."""


class ConnectivityException(TransformException):
    """The two frames do not belong to one tree."""


class ExtrapolationException(TransformException):
    """The time lies outside of what is known."""


class InvalidArgumentException(TransformException):
    """A frame's name or a transform is not valid."""


class TimeoutException(TransformException):
    """It did not come in time."""
