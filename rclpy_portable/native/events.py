"""Events of endpoints: who was found, what could not match, which deadline was missed."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from . import machine
from .enums import PolicyKind, PublisherEvent, SubscriptionEvent
from .errors import UnsupportedEventTypeError
from .handles import Destroyable

if TYPE_CHECKING:
    from .endpoints import Publisher, Subscription


class _Status:
    """What has happened, and what since the last look."""

    def count(self, times: int) -> None:
        """Note that it has happened again."""

    def taken(self) -> Any:
        """Return what is to be told now; from then on changes count from here."""
        told = type(self)()
        told.__dict__.update(self.__dict__)
        for name in [name for name in vars(self) if name.endswith("_change")]:
            setattr(self, name, 0)
        return told


class _Counted(_Status):
    """How often something has happened, and how often since the last look."""

    total_count = 0
    total_count_change = 0

    def count(self, times: int) -> None:
        self.total_count += times
        self.total_count_change += times


class rmw_requested_deadline_missed_status_t(_Counted):  # noqa: N801
    pass


class rmw_offered_deadline_missed_status_t(_Counted):  # noqa: N801
    pass


class rmw_liveliness_lost_status_t(_Counted):  # noqa: N801
    pass


class rmw_message_lost_status_t(_Counted):  # noqa: N801
    pass


class rmw_incompatible_type_status_t(_Counted):  # noqa: N801
    pass


class rmw_requested_qos_incompatible_event_status_t(_Counted):  # noqa: N801
    last_policy_kind = PolicyKind.RMW_QOS_POLICY_INVALID


class rmw_matched_status_t(_Counted):  # noqa: N801
    current_count = 0
    current_count_change = 0


class rmw_liveliness_changed_status_t(_Status):  # noqa: N801
    alive_count = 0
    not_alive_count = 0
    alive_count_change = 0
    not_alive_count_change = 0


KINDS: dict[PublisherEvent | SubscriptionEvent, type[_Status]] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED: rmw_offered_deadline_missed_status_t,
    PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST: rmw_liveliness_lost_status_t,
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: (
        rmw_requested_qos_incompatible_event_status_t
    ),
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE: rmw_incompatible_type_status_t,
    PublisherEvent.RCL_PUBLISHER_MATCHED: rmw_matched_status_t,
}
SUBSCRIPTION_KINDS: dict[SubscriptionEvent, type[_Status]] = {
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED: (
        rmw_requested_deadline_missed_status_t
    ),
    SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED: rmw_liveliness_changed_status_t,
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: (
        rmw_requested_qos_incompatible_event_status_t
    ),
    SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST: rmw_message_lost_status_t,
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: rmw_incompatible_type_status_t,
    SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED: rmw_matched_status_t,
}


class Statuses:
    """What has happened to one endpoint, by kind."""

    def __init__(self, kinds: dict[Any, type[_Status]]) -> None:
        self.kinds = kinds
        self._known: dict[int, Any] = {}
        self._untold: set[int] = set()

    def note(self, kind: int, times: int = 1, **changes: Any) -> None:
        """Note that something has happened; `changes` are set, those of *_change added."""
        status = self._known.get(kind)
        if status is None:
            status = self._known[kind] = self.kinds[kind]()
        status.count(times)
        for name, value in changes.items():
            setattr(status, name, getattr(status, name) + value if "change" in name else value)
        self._untold.add(kind)
        machine.changed()

    def is_untold(self, kind: int) -> bool:
        """Return whether something of this kind has happened since the last look."""
        return kind in self._untold

    def take(self, kind: int) -> Any:
        """Return what has happened since the last look, if anything has."""
        self._untold.discard(kind)
        return self._known.setdefault(kind, self.kinds[kind]()).taken()


class Watch:
    """A deadline or lease, by the machine's clock: it counts the periods in which nothing came."""

    def __init__(self, period: int, missed: Callable[[int], None], *, once: bool = False) -> None:
        self._period = period  # [ns]
        self._missed = missed
        self._once = once
        self._since: int | None = None  # [ns]; None: not begun

    def feed(self) -> None:
        """Begin the period anew."""
        self._since = machine.wall_ns()

    def look(self) -> None:
        """Tell of the periods that are over."""
        if self._since is None:
            return
        periods = (machine.wall_ns() - self._since) // self._period
        if periods > 0:
            self._since = None if self._once else self._since + periods * self._period
            self._missed(1 if self._once else periods)

    def due(self) -> int | None:
        """Return when to look [ns since 1970]; None: nothing is due."""
        return None if self._since is None else self._since + self._period


class EventHandle(Destroyable):
    """One kind of event of one endpoint."""

    def __init__(self, parent: Publisher | Subscription, kind: int) -> None:
        if kind not in parent.statuses.kinds:
            raise UnsupportedEventTypeError(f"event {kind!r} is unsupported")
        self._parent = parent
        self._kind = kind

    @property
    def ready(self) -> bool:
        """There is something to tell."""
        for watch in self._parent.watches:
            watch.look()
        return self._parent.statuses.is_untold(self._kind)

    def due(self) -> int | None:
        """Return when to look again, though nothing may have come [ns since 1970]."""
        times = [due for watch in self._parent.watches if (due := watch.due()) is not None]
        return min(times, default=None)

    def take_event(self) -> Any:
        """Return what has happened since the last look, if anything has."""
        return self._parent.statuses.take(self._kind)
