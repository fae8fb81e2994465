"""The link's frames: what judge and host may say to each other, and how much of it.

One frame is a 4-byte little-endian length and a MessagePack body. The judge decodes every body into
the typed structures below, so a frame of another shape is refused, not interpreted.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Annotated, Any, ClassVar

import msgspec

MAX_FRAME = 8 * 1024 * 1024  # [bytes] one frame, length excluded
MAX_PUBLISHED = 4_000  # messages a node may publish between two events of the world
MAX_PUBLISHED_BYTES = MAX_FRAME // 2  # of these messages and their names
MAX_ENDPOINTS = 500  # new ones, in a frame: a program may have more
MAX_CONNECTED = 1_000  # in a pulse: ends of a program
MAX_LEAD = 20_000_000_000  # [ns] that a program may sleep before the scenario begins
MAX_TEXT = 20_000  # [characters] of one error text or traceback
MAX_NAME = 256  # [characters] of a topic, type or node name (ROS itself stops at 255)
MAX_LOOKS = 20  # moments of one run
LENGTH = struct.Struct("<I")
# In stdout and stderr, followed by the time [ns]: what comes next was said then. ".7" after that
# says that it was the stream's seventh turn at that time.
MARK = "\x1e"

Name = Annotated[str, msgspec.Meta(max_length=MAX_NAME)]
Text = Annotated[str, msgspec.Meta(max_length=MAX_TEXT)]
Nanoseconds = Annotated[int, msgspec.Meta(ge=0, le=2**62)]


class Delivery(msgspec.Struct, array_like=True, frozen=True):
    """One message on its way to the node."""

    topic: Name
    data: bytes  # CDR


class Offer(msgspec.Struct, array_like=True, frozen=True):
    """A topic that the robot publishes."""

    topic: Name
    type: Name
    reliable: bool
    latched: bool = False  # sent once; later subscriptions, transient local, get it too


Span = tuple[Nanoseconds, Nanoseconds]  # [ns] at least, at most


class Discovery(msgspec.Struct, frozen=True):
    """How long DDS takes until the ends of topics and services have found each other."""

    program: Span = (0, 0)  # from a program's first node until others know the program
    late: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0  # share of later ends found late ...
    end: Span = (0, 0)  # ... and by how much
    latched: Span = (0, 0)  # until a later subscription has what was sent before it


class ProgramStart(msgspec.Struct, frozen=True):
    """A program to run; on a robot it would be a process of its own."""

    file: str
    arguments: tuple[str, ...] = ()  # what follows the file name in sys.argv
    start: Nanoseconds = 0  # [ns] since the start
    stop: Nanoseconds | None = None  # [ns]; it is killed then
    hides: tuple[Name, ...] = ()  # libraries that seem not installed to it
    entry: str = ""  # "module:function" of a package, which `ros2 run` calls; "": the file is run
    spared: bool = False  # one of several of a launch file: where it ends, the others go on
    asked: dict[str, str] | None = {}  # parameters that are to reach it; None: nobody is told


class Start(msgspec.Struct, frozen=True, tag="start"):
    """The judge's first frame: what to run and what the robot offers."""

    MAX_STDIN: ClassVar = 1024 * 1024  # [bytes]
    MAX_KEYS: ClassVar = 4096  # [bytes]

    programs: tuple[ProgramStart, ...]
    epoch: Nanoseconds  # ROS time of the start
    seed: int  # for `random`, in case the student uses it
    offers: tuple[Offer, ...]
    domain: int = 0  # of DDS; for a host in real time
    lead: Annotated[int, msgspec.Meta(ge=0, le=MAX_LEAD)] = 0  # [ns] to begin before the scenario
    charge_compute: bool = False  # CPU time costs virtual time; never so in a grading
    stdin: Annotated[bytes, msgspec.Meta(max_length=MAX_STDIN)] = b""  # what the programs may read
    discovery: Discovery = Discovery()  # by default all is found at once
    keys: Annotated[bytes, msgspec.Meta(max_length=MAX_KEYS)] = b""  # what somebody types, instead
    env: tuple[tuple[Name, Text], ...] = ()  # of the programs' environment: name and value
    # [ns] to look into; the launcher has to have imported `Moment.LIBRARY`, as no grader's has
    look: Annotated[tuple[Nanoseconds, ...], msgspec.Meta(max_length=MAX_LOOKS)] = ()


class Question(msgspec.Struct, array_like=True, frozen=True):
    """What a program asks the judge; its launcher's owner knows the bytes."""

    number: Nanoseconds  # the host's own, to find who asked
    data: bytes


class Told(msgspec.Struct, array_like=True, frozen=True):
    """The answer to a question."""

    number: Nanoseconds
    data: bytes
    wait: Nanoseconds = 0  # [ns] in a start-up, before the scenario: the host lets them pass


class Run(msgspec.Struct, frozen=True, tag="run"):
    """Deliver these messages now, then let time pass until `until` [ns since the start]."""

    until: Nanoseconds
    deliver: tuple[Delivery, ...] = ()
    told: tuple[Told, ...] = ()
    interrupt: bool = False  # the scenario is over: send the programs SIGINT first
    ends: bool = False  # come back, before time goes on, with ends of topics that are new


class Answers(msgspec.Struct, frozen=True, tag="answers"):
    """To a host in real time: what the judge says, now."""

    told: tuple[Told, ...]


class Script(msgspec.Struct, frozen=True, tag="script"):
    """Run a program that returns, in real time."""

    file: str
    arguments: tuple[str, ...]
    seed: Annotated[int, msgspec.Meta(ge=0, lt=2**32)]  # of `random` and numpy's generator


class Task(msgspec.Struct, frozen=True, tag="task"):
    """Carry out an order in the host: a function of the launcher's owner, who knows the bytes."""

    function: Name  # "module:function"; it takes bytes and returns bytes
    data: bytes


class Published(msgspec.Struct, array_like=True, frozen=True):
    """One message that the node published."""

    time: Nanoseconds  # [ns] since the start; from a radio: since 1970
    topic: Name
    type: Name
    data: bytes  # CDR


ENDS = "publisher|subscription|service|client|action server|action client|timer"


class EndpointReport(msgspec.Struct, array_like=True, frozen=True):
    """An end of a topic, service or action of the node's; a timer beyond TIMERS."""

    kind: Annotated[str, msgspec.Meta(pattern=f"^({ENDS})$")]
    node: Name
    topic: Name
    type: Name
    reliability: Name = ""
    durability: Name = ""
    depth: int = 0
    mismatch: Text = ""  # why it and the robot's end of the topic can't talk; "" if they can
    process: Nanoseconds = 0  # of which program, counted as in `Start`


NOTED = (
    "lost", "lifecycle", "lasts", "awaits", "stuck", "waits", "threads", "sim_time", "params",
    "imports", "ended", "asked", "sleeps", "timer", "type",
)  # fmt: skip


class Note(msgspec.Struct, array_like=True, frozen=True):
    """A note on a run for a person: no message shows it, and no check judges it."""

    MOST: ClassVar = 100  # of a run
    MAX_NAME: ClassVar = MAX_NAME  # [characters]
    OWN_TIMER: ClassVar = "its own timer"  # `more` of "waits"
    DECLARED: ClassVar = "; "  # in `more` of "asked", between what is missing and what is declared

    kind: Annotated[str, msgspec.Meta(pattern=f"^({'|'.join(NOTED)})$")]
    about: Name  # a topic, a node, a program, a function, sections ...
    line: Name = ""  # ... and where: "node.py, line 12"
    count: Nanoseconds = 1
    time: Nanoseconds = 0  # [ns] when it began, or the longest of them
    lasted: Nanoseconds = 0  # [ns]
    more: Name = ""  # a state, a service, a topic, what had to wait, how it ended


Notes = Annotated[list[Note], msgspec.Meta(max_length=Note.MOST)]


class Value(msgspec.Struct, array_like=True, frozen=True):
    """A variable of a program, in words."""

    MOST: ClassVar = 40  # in one place

    name: Name
    text: Name
    before: Name = ""  # what it was when the callback began; "": it was not there


Values = Annotated[list[Value], msgspec.Meta(max_length=Value.MOST)]


class Place(msgspec.Struct, array_like=True, frozen=True):
    """A function of a program under way: where it stands ("node.py, line 12"), and its locals."""

    MOST: ClassVar = 4  # of a moment's stack, the innermost first

    function: Name
    line: Name
    values: Values = []


Places = Annotated[list[Place], msgspec.Meta(max_length=Place.MOST)]


class Sending(msgspec.Struct, array_like=True, frozen=True):
    """A message that left a program."""

    time: Nanoseconds
    topic: Name
    text: Text  # the message
    places: Places
    by: Name = ""  # a thread, or an earlier callback; "": the callback itself


class Moment(msgspec.Struct, array_like=True, frozen=True):
    """A function's last callback that had begun by a time, in a drive in which that is asked.

    Nothing of it is judged: a program may have made it up.
    """

    LIBRARY: ClassVar = "rclpy_virtual_time.host.look"
    MOST: ClassVar = 10  # messages that left meanwhile
    FUNCTIONS: ClassVar = 4  # of a program by each time, those that began last; the last is last

    asked: Nanoseconds
    program: Nanoseconds  # counted as in `Start`
    time: Nanoseconds  # when it began
    lasted: Nanoseconds | None  # [ns]; None: it was not over when the run was
    kind: Annotated[
        str, msgspec.Meta(pattern="^(subscription|timer|service|answer|task|other|program)$")
    ]
    about: Name  # the topic, the timer's period, the service
    node: Name
    place: Place  # the function, and where it begins
    message: Name  # the class of what came ...
    fields: Values  # ... and its fields; of what has none, all of it without a name
    values: Values  # of the node, and of what else the function keeps
    sent: Annotated[list[Sending], msgspec.Meta(max_length=MOST)]
    more: Nanoseconds  # how many more it sent
    answered: Text  # by a service
    raised: Text
    raised_in: Places


Moments = Annotated[list[Moment], msgspec.Meta(max_length=1500)]


class Settled(msgspec.Struct, frozen=True, tag="settled"):
    """All that the node has to do until `now` is done."""

    MAX_QUESTIONS: ClassVar = 64  # to the judge, at a time

    now: Nanoseconds
    spinning: bool  # an executor waits for work, or has looked for some
    asleep: bool  # some thread waits for a time
    published: Annotated[list[Published], msgspec.Meta(max_length=MAX_PUBLISHED)]
    endpoints: Annotated[list[EndpointReport], msgspec.Meta(max_length=MAX_ENDPOINTS)] = []
    asked: Annotated[list[Question], msgspec.Meta(max_length=MAX_QUESTIONS)] = []
    starting: bool = False  # the program starts up, before the scenario, and waits for an answer
    notes: Notes = []  # new or changed ones
    moments: Moments = []  # as much as is known by now
    parked: Nanoseconds = 0  # when a thread ran last


class Ended(msgspec.Struct, frozen=True, tag="ended"):
    """The student's program is over."""

    NO_NODE: ClassVar = " and made no node"  # at the end of `text`
    ASKED_TO_END: ClassVar = ("KeyboardInterrupt", "ExternalShutdownException")  # by SIGINT

    now: Nanoseconds
    kind: Annotated[
        str, msgspec.Meta(pattern="^(returned|exited|exception|syntax_error|flooded|real_time)$")
    ]
    text: Text
    detail: Text  # the traceback, with the student's frames
    published: Annotated[list[Published], msgspec.Meta(max_length=MAX_PUBLISHED)]
    endpoints: Annotated[list[EndpointReport], msgspec.Meta(max_length=MAX_ENDPOINTS)] = []
    notes: Notes = []
    moments: Moments = []


class TuneIn(msgspec.Struct, frozen=True, tag="tune_in"):
    """The judge's first frame to a radio, the robot's ends of topics in real time."""

    domain: int
    offers: tuple[Offer, ...]


class Meet(msgspec.Struct, frozen=True, tag="meet"):
    """The radio is to make the robot's ends for these endpoints of a node."""

    endpoints: tuple[EndpointReport, ...]


class Transmit(msgspec.Struct, frozen=True, tag="transmit"):
    """The radio is to send these messages now."""

    deliver: tuple[Delivery, ...]


class Pulse(msgspec.Struct, frozen=True, tag="pulse"):
    """The state of a program that runs in real time; sent several times a second."""

    spun: Nanoseconds  # since 1970, when an executor first waited for work; 0: not yet
    busy: float  # [s] since an executor last waited for work; 0 if one does now
    endpoints: Annotated[list[EndpointReport], msgspec.Meta(max_length=MAX_ENDPOINTS)]  # new ones
    # "kind topic": how many ends of others it has found
    connected: Annotated[dict[Name, int], msgspec.Meta(max_length=MAX_CONNECTED)]
    notes: Notes = []

    @property
    def spinning(self) -> bool:
        """An executor has begun to wait for work."""
        return self.spun > 0


class Asking(msgspec.Struct, frozen=True, tag="asking"):
    """A program in real time asks the judge."""

    asked: Annotated[list[Question], msgspec.Meta(max_length=Settled.MAX_QUESTIONS)]


class Tuned(msgspec.Struct, frozen=True, tag="tuned"):
    """What the radio made of a node's endpoints, and how many of them its ends have found."""

    # with mismatches
    endpoints: Annotated[list[EndpointReport], msgspec.Meta(max_length=MAX_ENDPOINTS)]
    connected: dict[Name, int]  # "kind topic", of the node's end


class HeardNow(msgspec.Struct, frozen=True, tag="heard"):
    """What the radio heard, with the real time [ns since 1970] at which it was sent."""

    published: Annotated[list[Published], msgspec.Meta(max_length=MAX_PUBLISHED)]


class Carried(msgspec.Struct, frozen=True, tag="carried"):
    """The result of a task."""

    data: bytes


class RunTest(msgspec.Struct, frozen=True, tag="run_test"):
    """Run one test of pytest's in virtual time; it is the user's own."""

    test: str  # its node id, with an absolute path
    options: dict[str, Any]  # of pytest's command line
    worker: dict[str, Any]  # what pytest-xdist tells its workers
    folder: str
    environment: dict[str, str]
    path: tuple[str, ...]  # of modules
    limit: Nanoseconds  # [ns] of virtual time
    seed: int = 0


class Reported(msgspec.Struct, frozen=True, tag="reported"):
    """One of the test's reports or warnings, as JSON."""

    report: str


ENTERED, REFUSED = b"+", b"!"  # a host's first word about itself, before any of the student's


class Request(msgspec.Struct, frozen=True, tag="host"):
    """What the judge asks for: a host in this folder, as this user (0: the judge's own)."""

    folder: str
    uid: int
    layers: tuple[str, ...]  # of isolation, by their names in `sandbox/layers.py`
    priority: bool = False  # it goes before others on the machine from its start on


class Furnish(msgspec.Struct, frozen=True, tag="furnish"):
    """What the judge asks for: a file system of limited size over this folder, for this user."""

    folder: str
    uid: int


class Clear(msgspec.Struct, frozen=True, tag="clear"):
    """What the judge asks for: take away what `Furnish` made; there is no answer."""

    folder: str


class Hello(msgspec.Struct, frozen=True):
    """The fork server's first words: ready, and what it can do for isolation."""

    layers: tuple[str, ...]  # of isolation that this machine has
    landlock: int = 0  # the version of Landlock that is used (its ABI); 0: none
    counted: bool = False  # the kernel limits the processes and threads of each host


class Birth(msgspec.Struct, frozen=True, tag="birth"):
    """The answer to a request; the child's pidfd comes with it."""

    pid: int


class Done(msgspec.Struct, frozen=True, tag="done"):
    """The answer to `Furnish`; a descriptor of the folder comes with it."""


class Fault(msgspec.Struct, frozen=True, tag="fault"):
    """The answer if the system refuses."""

    text: str


class Slept(msgspec.Struct, frozen=True, tag="slept"):
    """The program slept before it first waited for work or spoke: start it so much earlier."""

    lead: Annotated[int, msgspec.Meta(gt=0, le=MAX_LEAD)]  # [ns]


ToHost = (
    Start | Run | Answers | Script | Task | TuneIn | Meet | Transmit | RunTest
)  # fmt: skip
ToJudge = Settled | Ended | Slept  # from a host that runs nodes
FromLive = Pulse | Asking | Ended  # from a host that runs a node in real time
FromRadio = Tuned | HeardNow
FromScript = Ended | Carried  # from a host that runs scripts, or carries out a task
FromTest = Reported | Ended  # from a host that runs a test


def _plain(value: Any) -> Any:
    """Return what the program's own subclass of int, str or float is: rclpy takes these, too."""
    for kind, plain in ((int, "__int__"), (str, "__str__"), (float, "__float__")):
        if isinstance(value, kind):
            return getattr(kind, plain)(value)  # never the program's own
    raise TypeError(f"a frame carries no {type(value).__name__}")


_encoder = msgspec.msgpack.Encoder(enc_hook=_plain)
# What each side decodes, or msgspec.DecodeError: nothing but one of its frames passes.
decode_to_host: Callable[[bytes], ToHost] = msgspec.msgpack.Decoder(ToHost).decode
decode_to_judge: Callable[[bytes], ToJudge] = msgspec.msgpack.Decoder(ToJudge).decode
decode_from_script: Callable[[bytes], FromScript] = msgspec.msgpack.Decoder(FromScript).decode
decode_from_test: Callable[[bytes], FromTest] = msgspec.msgpack.Decoder(FromTest).decode
decode_from_live: Callable[[bytes], FromLive] = msgspec.msgpack.Decoder(FromLive).decode
decode_from_radio: Callable[[bytes], FromRadio] = msgspec.msgpack.Decoder(FromRadio).decode


def encode(frame: ToHost | ToJudge | FromScript | FromTest | FromLive | FromRadio) -> bytes:
    """Return the frame with its length in front.

    Raises ValueError: the body is larger than MAX_FRAME.
    """
    body = _encoder.encode(frame)
    if len(body) > MAX_FRAME:
        raise ValueError(f"a frame of {len(body)} bytes; the link carries {MAX_FRAME}")
    return LENGTH.pack(len(body)) + body
