"""Who is connected with whom over topics and services, and why an end is not.

The terminal and the drawing of the graph say the same sentences: these.
"""

from __future__ import annotations

import difflib
from collections import Counter

from grader.recording.recording import Endpoint, Recording
from sim.messages import CMD_VEL_TOPIC, GOAL_TOPIC, TWIST, TWIST_STAMPED
from sim.scenario_files import load_scenario, scenario_names
from sim.sensors import OFFERED, enabled_sensors

COMMANDS = (TWIST, TWIST_STAMPED)  # types of messages that the robot understands
OF_CARS = "ackermann_msgs/"  # how the types of what drives other robots begin
OURS = "/from_node"  # before topics on which the node speaks in the robot's name
ALIKE = 0.75  # two names
MEANT, LONG = 30, 60  # names that are compared, and how much of each: its end
RATED = 1.0  # [s] that a node has to be there for a rate of its messages, and for missing ones
MOST_NOTED = 490.0  # [Hz] a loop without a wait publishes more, and in real time 500 are noted
DEMOS = "demo_"  # how the scenarios begin that are for any node
TF = {"/tf", "/tf_static"}
LIFECYCLE = "lifecycle_msgs/"  # the ends of such a node that rclpy makes in C: nobody sees them
OF_ALL = ("describe_param", "get_param", "get_type_desc", "list_param", "set_param")  # services


class Wiring:
    """The connections of a recording's ends."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._ends = recording.endpoints
        self.sent = Counter(m.topic for m in recording.delivered)  # messages of the robot, by topic
        self.said = Counter((m.topic.removeprefix(OURS), m.type) for m in recording.published)
        done = recording.outcome.completed
        self.lasted = recording.duration_s if done else recording.outcome.at  # [s] of the node

    def messages(self, end: Endpoint) -> str:
        """Say how many messages an end sent or could hear; "" for services."""
        if end.kind not in ("publisher", "subscription"):
            return ""
        return self.told(*self._count(end))

    def told(self, count: int, words: str = "{}") -> str:
        """Say that there were so many messages, and with which rate."""
        said = words.format(f"{count} message{'' if count == 1 else 's'}")
        rated = count > 1 and self.lasted >= RATED
        return f"{said} ({count / self.lasted:.1f} Hz)" if rated else said

    def _count(self, end: Endpoint) -> tuple[int, str]:
        """Return the number of messages of an end, and the words for them.

        Which of several publishers sent a message is not known, nor whether one of the programs'
        own came in time for a subscription of theirs.
        """
        own = self.said[end.topic, end.type]
        if end.kind == "publisher":
            kind = (end.kind, end.topic, end.type)
            alike = [o for o in self._ends if (o.kind, o.topic, o.type) == kind]
            many = self._recording.live and own > MOST_NOTED * self.lasted
            words = "more than {}" if many else "{}"
            return own, f"{words} together" if len(alike) > 1 else words
        robots = 0 if end.mismatch else self.sent[end.topic]
        if not own or not self._publishers(end, connected=True):
            return robots, "{}"
        return robots + own, "up to {}"

    def fault(self, end: Endpoint) -> str:
        """Say in a sentence why an end of the student's is connected with nothing; "" if it is."""
        match end.kind:
            case "publisher":
                return self._of_publisher(end)
            case "subscription":
                return self._of_subscription(end)
            case "client" if not self._served(end):
                return "nobody offers this service: calls are never answered"
            case "action client" if not self._served(end):
                return "nobody offers this action: goals are never taken"
        return ""

    def _of_publisher(self, end: Endpoint) -> str:
        alike = difflib.SequenceMatcher(None, end.topic, CMD_VEL_TOPIC).ratio() >= ALIKE
        drives = end.type in COMMANDS or end.type.startswith(OF_CARS)
        if end.topic == CMD_VEL_TOPIC:
            deaf = end.type not in COMMANDS
            return f"the robot does not hear this: it takes {TWIST} here" if deaf else ""
        if any((o.topic, o.type) == (end.topic, end.type) for o in self._all("subscription")):
            return ""
        if meant := self._meant(end, "subscription"):
            return f"nobody listens here: {meant.node} listens to {meant.topic}"
        given = [word for each in self._recording.scenario.program for word in each.arguments]
        space, _, name = end.topic.rpartition("/")
        if end.node.rpartition("/")[0] == space and any(w.endswith(f":={name}") for w in given):
            return ""  # the scenario named it so, and runs a part of the programs
        if drives or alike:
            return f"nobody listens here: the robot takes {TWIST} on {CMD_VEL_TOPIC}"
        return ""

    def _of_subscription(self, end: Endpoint) -> str:
        """Say why nothing arrives; empty if something can."""
        sent, recording = self.sent, self._recording
        if self._publishers(end, connected=True) or (sent[end.topic] and not end.mismatch):
            return ""
        node = end.topic.rpartition("/")[0]
        if end.type.startswith(LIFECYCLE) and any(other.node == node for other in self._ends):
            return ""  # the node tells of its own states
        if end.mismatch:
            return f"nothing arrives: {end.mismatch}"
        for other in self._publishers(end):
            if other.type != end.type:
                return f"nothing arrives: {other.node} publishes {other.type} here"
            return f"nothing arrives: {_qos_mismatch(other, end)}"
        if end.topic in OFFERED:
            if self.lasted < RATED:
                return ""  # it had no time to hear anything
            if end.topic in TF and not TF.isdisjoint(sent):
                return ""  # who listens to transforms listens to both
            hint = "; --goal X Y sends a goal" if end.topic == GOAL_TOPIC else _where(end.topic)
            return f"the robot sends nothing here in {recording.name}{hint}"
        if meant := self._meant(end, "publisher"):
            return f"nobody publishes this topic; {meant.node} publishes {meant.topic}"
        near = difflib.get_close_matches(end.topic, sorted(sent), n=1, cutoff=ALIKE)
        near = near or [topic for topic in sorted(sent) if OFFERED.get(topic) == end.type]
        has = near[0] if near else ", ".join(sorted(sent))
        return "nobody publishes this topic" + (f"; the robot publishes {has}" if has else "")

    def _meant(self, end: Endpoint, kind: str) -> Endpoint | None:
        """Return an end of the programs' that is alone as well, and whose name is much like it."""
        mates = {mate.topic for mate in self._all(end.kind)}
        alone = [o for o in self._all(kind) if o.type == end.type and o.topic not in mates]
        by_end = {other.topic[-LONG:]: other for other in alone[:MEANT]}
        found = difflib.get_close_matches(end.topic[-LONG:], by_end, n=1, cutoff=ALIKE)
        return by_end[found[0]] if found else None

    def _all(self, kind: str) -> list[Endpoint]:
        return [end for end in self._ends if end.kind == kind]

    def _publishers(self, end: Endpoint, *, connected: bool = False) -> list[Endpoint]:
        """Return the programs' own publishers of a topic, or those that an end hears."""
        found = [other for other in self._all("publisher") if other.topic == end.topic]
        if not connected:
            return found
        return [each for each in found if each.type == end.type and not _qos_mismatch(each, end)]

    def _served(self, client: Endpoint) -> bool:
        node, _, service = client.topic.rpartition("/")
        if service.startswith(OF_ALL) or client.type.startswith(LIFECYCLE):  # in each such node
            return any(end.node == node for end in self._ends)
        offers = "service" if client.kind == "client" else "action server"
        wanted = (offers, client.topic, client.type)
        return any((end.kind, end.topic, end.type) == wanted for end in self._ends)


def _where(topic: str) -> str:
    """Say in which scenarios for any node the robot has the sensor."""
    demos = [load_scenario(name) for name in scenario_names() if name.startswith(DEMOS)]
    sent = {d.name: {s.topic for s in enabled_sensors(d).values()} for d in demos if not d.program}
    having = ", ".join(name for name, topics in sent.items() if topic in topics)
    return f"; it does in {having}" if having else ""


def _qos_mismatch(publisher: Endpoint, subscription: Endpoint) -> str:
    if (publisher.reliability, subscription.reliability) == ("best_effort", "reliable"):
        return "best effort publisher and reliable subscription"
    if (publisher.durability, subscription.durability) == ("volatile", "transient_local"):
        return "volatile publisher and transient local subscription"
    return ""
