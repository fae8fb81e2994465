"""A warm process that forks a host per trial.

It has imported rclpy and the common interfaces (never called `rclpy.init`, started no thread) and
holds no secret. The judge sends one request per trial, with the descriptors of the link; the answer
is the child's pidfd, later its wait status. A fork server for scripts, which return, has neither
rclpy nor virtual time; one for tests has both, and pytest.
"""

from __future__ import annotations

import array
import atexit
import contextlib
import faulthandler
import functools
import gc
import importlib
import inspect
import os
import signal
import socket
import sys
import tempfile
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from select import select as wait_for_real  # before the kernel replaces it
from types import FrameType
from typing import Any, NamedTuple

import msgspec

from . import advice as advice_module
from . import imports, scripts, stand_ins
from .frames import ENTERED, REFUSED, Birth, Clear, Done, Fault, Furnish, Hello, Moment, Request
from .kinds import LIVE, NODES, TESTS
from .virtual import kernel as kernel_module
from .virtual import threads
from .wire import Wire

HOME = ".home"  # below the node's folder: what lies beside a node does not lie in ~
REQUEST_DESCRIPTORS = 5  # link in, link out, stdout, stderr, status
TYPES = (  # of every node and of many, loaded with their C libraries
    "rcl_interfaces/msg/ParameterEvent",
    "rcl_interfaces/msg/Log",
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/PoseStamped",
    "nav_msgs/msg/Odometry",
    "sensor_msgs/msg/LaserScan",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Float64",
    "std_msgs/msg/String",
    "std_msgs/msg/UInt32",
    "std_srvs/srv/Trigger",
    "rcl_interfaces/srv/DescribeParameters",
    "rcl_interfaces/srv/GetParameterTypes",
    "rcl_interfaces/srv/GetParameters",
    "rcl_interfaces/srv/ListParameters",
    "rcl_interfaces/srv/SetParameters",
    "rcl_interfaces/srv/SetParametersAtomically",
    "type_description_interfaces/srv/GetTypeDescription",
)
MAX_REASON = 300  # [bytes] of why a host could not begin


class Child(NamedTuple):
    """A host that lives."""

    pid: int
    status: int  # descriptor: the judge waits there for the exit status
    uid: int


Body = Callable[[int, int], None]  # what a host does with its link: descriptors to read and write


def serve(
    control: socket.socket,
    epoch: int,
    kind: str,
    layers: Collection[str],
    landlock: int,
    advice: str,
    libraries: Sequence[str],
) -> None:
    """Fork hosts until the judge closes `control`; import `libraries` before: modules, types.

    `layers` are the layers of isolation that the judge wants, if the machine has them, and
    `landlock` is the newest version of Landlock that is to be used; `advice` names an `Advice`.
    """
    from .sandbox import layers as sandbox_layers  # noqa: PLC0415  (only Linux can import it)

    may_mount = sandbox_layers.begin(layers)
    body = prepared(kind, epoch, advice, libraries)
    means = sandbox_layers.prepare(layers, may_mount=may_mount, newest=landlock)
    control.sendall(msgspec.json.encode(means))
    if kind == NODES:
        _load_libraries()
        imports.host.lay_aside([name.partition(".")[0] for name in (__name__, advice)])
    gc.enable()  # its imports were made without
    gc.freeze()
    _fill_heap()
    children: dict[int, Child] = {}  # by pidfd
    while True:
        readable, _, _ = wait_for_real([control.fileno(), *children], [], [])
        for pidfd in readable:
            if pidfd in children:
                child = children.pop(pidfd)
                _bury(pidfd, child, alone=all(c.uid != child.uid for c in children.values()))
        if control.fileno() in readable and not _answer(control, body, means, children):
            break
    for pidfd, child in children.items():  # the judge is gone, maybe killed: so are its hosts
        _bury(pidfd, child, alone=True)


def _load_libraries() -> None:
    """Load the shared libraries that a node's endpoints ask for by name, not in each host anew."""
    import ctypes  # noqa: PLC0415
    import pwd  # noqa: PLC0415  (only Unix has it)

    from .sandbox import users  # noqa: PLC0415

    for package in {name.partition("/")[0] for name in TYPES}:
        for kind in ("fastrtps_c", "introspection_c"):
            with contextlib.suppress(OSError):
                ctypes.CDLL(f"lib{package}__rosidl_typesupport_{kind}.so")
    with contextlib.suppress(KeyError):  # Fast DDS asks who it is, which loads glibc's plug-ins
        pwd.getpwuid(users.USERS.start)


def _fill_heap() -> None:
    """Take up the gaps that imports have left in the heap of the C library, for good.

    They lie in a thousand pages. Of each that a host wrote to, Linux would have to make a copy.
    """
    import ctypes  # noqa: PLC0415

    class Mallinfo(ctypes.Structure):
        _fields_ = (("other", ctypes.c_size_t * 9), ("keepcost", ctypes.c_size_t))

    libc = ctypes.CDLL(None)
    if not hasattr(libc, "mallinfo2"):  # glibc has it since 2.33
        return
    libc.mallinfo2.restype = Mallinfo
    libc.malloc.restype, libc.malloc.argtypes = ctypes.c_void_p, (ctypes.c_size_t,)
    libc.sbrk.restype, libc.sbrk.argtypes = ctypes.c_size_t, (ctypes.c_ssize_t,)
    end = libc.sbrk(0) - libc.mallinfo2().keepcost
    for size in (2**power - 8 for power in range(16, 4, -1)):
        while (libc.malloc(size) or end) < end:
            pass


def prepared(kind: str, epoch: int, advice: str, libraries: Sequence[str]) -> Body:
    """Import what takes long; return what a host of this kind does with its link."""
    body: Body = scripts.serve
    if kind in (NODES, TESTS):
        kernel = prepare_nodes(epoch)
        body = functools.partial(_run_student, kernel, epoch)
        if kind == TESTS:
            body = functools.partial(_run_test, kernel, epoch)
            _warm_up_pytest()
    elif kind == LIVE:
        _warm_up(virtual=False)
        body = _run_live
    settle(advice, libraries)
    return body


def settle(advice: str, libraries: Sequence[str]) -> None:
    """Import what else hosts need; nothing is imported for them after that."""
    advice_module.use(advice)
    imports.host.warm()
    _import(libraries)
    inspect.getmodule(sys._getframe())  # it looks at all modules: a node's first log line would
    imports.host.settle()
    sys.dont_write_bytecode = True  # no files beside a program's sources


def prepare_nodes(epoch: int) -> kernel_module.Kernel:
    """Put virtual time under Python and import what nodes need; return its kernel."""
    kernel = kernel_module.Kernel()
    threads.install(kernel, epoch)
    _warm_up()
    return kernel


def _answer(control: socket.socket, body: Body, means: Hello, children: dict[int, Child]) -> bool:
    data, descriptors, _, _ = socket.recv_fds(control, 65536, REQUEST_DESCRIPTORS)
    if not data:
        return False
    request = msgspec.json.decode(data, type=Request | Furnish | Clear)
    if not isinstance(request, Request):
        _furnish_or_clear(control, request)
        return True
    parent = os.getpid()
    pid = os.fork()
    if pid == 0:
        control.close()
        for pidfd, child in children.items():
            os.close(pidfd)
            os.close(child.status)
        _become_host(request, means, parent, descriptors, body)
    *link, status = descriptors
    for descriptor in link:
        os.close(descriptor)
    pidfd = os.pidfd_open(pid)
    children[pidfd] = Child(pid, status, request.uid)
    _send_with(control, Birth(pid), pidfd)
    return True


def _furnish_or_clear(control: socket.socket, request: Furnish | Clear) -> None:
    from .sandbox import users, workplaces  # noqa: PLC0415

    folder = Path(request.folder)
    if isinstance(request, Clear):  # nobody waits: Linux takes milliseconds
        with contextlib.suppress(OSError):  # gone with the folder, which the judge has removed
            users.unmount(folder)
        return
    try:
        descriptor = workplaces.furnish(folder, request.uid)
    except OSError as error:
        control.sendall(msgspec.json.encode(Fault(str(error))))
        return
    _send_with(control, Done(), descriptor)
    os.close(descriptor)


def _send_with(control: socket.socket, answer: Birth | Done, descriptor: int) -> None:
    rights = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [descriptor]))
    control.sendmsg([msgspec.json.encode(answer)], [rights])


def _bury(pidfd: int, child: Child, *, alone: bool) -> None:
    """Reap a host and end what it started; `alone`: no other host is the same user."""
    from .sandbox import users  # noqa: PLC0415

    with contextlib.suppress(OSError):
        os.killpg(child.pid, signal.SIGKILL)  # not yet reaped, so the number is still its own
    if child.uid and alone:
        users.end_all_of(child.uid)
    _, wait_status = os.waitpid(child.pid, 0)
    with contextlib.suppress(OSError):
        os.write(child.status, f"{os.waitstatus_to_exitcode(wait_status)}\n".encode())
    os.close(child.status)
    os.close(pidfd)


def _become_host(
    request: Request, means: Hello, parent: int, descriptors: list[int], body: Body
) -> None:
    """Turn the forked child into a host and run the student's file; never returns."""
    from .sandbox import layers as sandbox_layers  # noqa: PLC0415

    link_in, link_out, out, err, status = descriptors
    try:
        _prepare_host(request, (out, err), live=body is _run_live)
        sandbox_layers.enter(request, means, parent=parent, datagrams=body is _run_live)
        Path.home().mkdir(exist_ok=True)
        os.write(status, ENTERED)
    except BaseException as error:  # nothing of the student's has run: the fault is ours
        reason = " ".join(f"{type(error).__name__}: {error}".split()).encode()[:MAX_REASON]
        os.write(status, REFUSED + reason + b"; exit code ")
        os._exit(70)
    os.close(status)  # what comes through it can't be the student's
    try:
        body(link_in, link_out)
    finally:
        os._exit(70)


def _tell_stacks(_: int, frame: FrameType | None) -> None:
    """Write the stacks of all threads to stderr, as faulthandler does.

    It reads those of threads that run meanwhile, which can end the process; here they wait.
    """
    with contextlib.suppress(Exception):
        for number, top in sys._current_frames().items():
            at = frame if top is sys._getframe() else top
            lines = [f"Thread 0x{number:016x} (most recent call first):"]
            while at is not None:
                code = at.f_code
                lines.append(f'  File "{code.co_filename}", line {at.f_lineno} in {code.co_name}')
                at = at.f_back
            os.write(2, ("\n".join(lines) + "\n\n").encode("utf-8", "backslashreplace"))


def _prepare_host(request: Request, output: tuple[int, int], *, live: bool) -> None:
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs ignore it
    null = os.open(os.devnull, os.O_RDONLY)
    for source, target in ((null, 0), (output[0], 1), (output[1], 2)):
        os.dup2(source, target)
        os.close(source)
    atexit._clear()  # what is registered from now on is the student's
    signal.signal(signal.SIGUSR1, _tell_stacks)
    faulthandler.register(signal.SIGUSR2, file=2, all_threads=True)  # where no handler runs
    os.chdir(request.folder)
    os.environ["HOME"] = str(Path(request.folder, HOME))
    os.environ["TMPDIR"] = request.folder
    os.environ["ROS_LOG_DIR"] = request.folder
    if live or request.priority:
        from .sandbox import users  # noqa: PLC0415

        if live:
            users.take_priority()
        if request.priority:
            users.prefer(os.getpid())


def _run_student(kernel: kernel_module.Kernel, epoch: int, link_in: int, link_out: int) -> None:
    run_trial(kernel, epoch, Wire(link_in, link_out))
    os._exit(0)


def run_trial(kernel: kernel_module.Kernel, epoch: int, wire: Wire) -> None:
    """Run the programs that the judge names first through a wire; once in a process."""
    from . import program  # noqa: PLC0415  (rclpy is imported by now)
    from .virtual import bridge, discovery, executors, session  # noqa: PLC0415

    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs ignore it
    trial = session.Session(wire)
    trial.kernel, kernel.world = kernel, trial
    kernel.begin(0)  # anew: imports have read its clocks
    start = trial.start()
    trial.charge_compute = start.charge_compute
    os.environ.update(start.env)
    if start.stdin:
        _give_input(start.stdin)
    if start.keys:
        from .virtual import keyboard  # noqa: PLC0415

        keyboard.install(kernel, start.keys)
    found = discovery.Discovery(kernel, start.discovery, start.seed)
    trial.bridge = bridge.Bridge(start.offers, found)
    trial.bridge.install()
    trial.clocks = executors.install(kernel, epoch, trial.bridge)
    trial.bridge.tell_rosout(trial.clocks.present, lambda: trial.turns.take(2))
    executors.refuse_real_time(trial.leave_for_real_time)
    if start.look:  # KeyError: this launcher's hosts can't
        trial.looker = sys.modules[Moment.LIBRARY].Looker(start.look, kernel)
        trial.looker.install()
    _steer_init()
    trial.mark()
    trial.turns.install()
    program.run(trial, start)


def _give_input(data: bytes) -> None:
    """Let the programs read this from stdin, as from a file."""
    with tempfile.TemporaryFile(dir=".") as file:
        file.write(data)
        file.seek(0)
        os.dup2(file.fileno(), 0)


def _run_test(kernel: kernel_module.Kernel, epoch: int, link_in: int, link_out: int) -> None:
    from .testing import session  # noqa: PLC0415  (rclpy and pytest are imported by now)

    _steer_init()
    session.serve(kernel, epoch, link_in, link_out)


def _run_live(link_in: int, link_out: int) -> None:
    from .real_time import node  # noqa: PLC0415  (rclpy is imported by now)

    _steer_init()
    node.serve(link_in, link_out)


def _steer_init() -> None:
    """Give every context the arguments that keep it inside the process."""
    import rclpy.context  # noqa: PLC0415

    cls: Any = rclpy.context.Context
    init = cls.init

    def quiet_init(self: Any, args: Any = None, **kwargs: Any) -> Any:
        arguments = list(sys.argv if args is None else args)
        self._course_arguments = tuple(arguments)
        arguments += ["--ros-args", "--disable-rosout-logs", "--disable-external-lib-logs"]
        return init(self, arguments, **kwargs)

    cls.init = quiet_init


def _warm_up(*, virtual: bool = True) -> None:
    stand_ins.offer()
    for name in TYPES:
        _load_type(name)
    _import(("numpy.random", "rclpy.node", "rclpy.executors", "rclpy.action"))
    from .interfaces import native  # noqa: F401, PLC0415  (no host may read rclpy_portable)

    if virtual:
        from . import asked, program  # noqa: F401, PLC0415
        from .virtual import bridge, executors, programs, session  # noqa: F401, PLC0415
    else:
        from .real_time import node  # noqa: F401, PLC0415


def _warm_up_pytest() -> None:
    from .testing import session  # noqa: PLC0415

    session.warm_up()


def _import(libraries: Sequence[str]) -> None:
    """Import modules that take long; programs that need a missing module fail later."""
    for name in libraries:
        with contextlib.suppress(ImportError):
            (_load_type if "/" in name else importlib.import_module)(name)


def _load_type(name: str) -> None:
    """Load a message type, "sensor_msgs/msg/LaserScan", with its C library."""
    from rclpy.type_support import check_for_type_support  # noqa: PLC0415

    module, _, type_ = name.replace("/", ".").rpartition(".")
    check_for_type_support(getattr(importlib.import_module(module), type_))
