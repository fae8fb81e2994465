"""What the kernel keeps a host from doing, for good: Landlock for files, seccomp for calls.

Both need no privileges and no library. Each layer stands alone: what this machine lacks, or a
person has switched off, is left out, and `course doctor` says what that opens.

Sources: landlock(7), `linux/landlock.h` (ABI 1 to 6), seccomp(2), `linux/bpf_common.h`, and the
system call tables of x86_64 and of arm64 (`asm-generic/unistd.h`).
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import signal
import stat
import struct
from collections.abc import Collection, Iterable
from pathlib import Path

PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_GET_SECCOMP, PR_SET_SECCOMP = 1, 4, 21, 22
PR_SET_NO_NEW_PRIVS = 38

# --- Landlock ------------------------------------------------------------------------------------

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446  # the same on every architecture
VERSION_FLAG = 1
PATH_BENEATH = 1
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1 << 0, 1 << 1, 1 << 2, 1 << 3
ABI_1_RIGHTS = (1 << 13) - 1  # up to MAKE_SYM
REFER, TRUNCATE, IOCTL_DEV = 1 << 13, 1 << 14, 1 << 15  # new with ABI 2, 3 and 5
TCP_RIGHTS = 0b11  # bind and connect, ABI 4
SCOPES = 0b11  # abstract sockets and signals stay inside, ABI 6
NEWEST = 6  # ABI that is known here
READING = READ_FILE | READ_DIR
OF_FILES = EXECUTE | WRITE_FILE | READ_FILE | TRUNCATE | IOCTL_DEV  # others are a folder's


def landlock_abi() -> int:
    """Return the version of the kernel's Landlock; 0 if it has none."""
    found = _libc().syscall(CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(VERSION_FLAG))
    return max(int(found), 0)


def restrict_files(read: Iterable[Path], write: Iterable[Path], newest: int = NEWEST) -> None:
    """Let this process see nothing but `read`, and change nothing outside `write`, for good.

    Of Landlock it uses what version `newest` has, as an older kernel would.

    Raises OSError: the kernel has no Landlock.
    """
    abi = min(landlock_abi(), newest)
    if not abi:
        raise OSError(errno.ENOSYS, "no Landlock")
    rights = ABI_1_RIGHTS
    for since, right in ((2, REFER), (3, TRUNCATE), (5, IOCTL_DEV)):
        rights |= right if abi >= since else 0
    net, scopes = (TCP_RIGHTS if abi >= 4 else 0), (SCOPES if abi >= 6 else 0)
    attributes = struct.pack("QQQ", rights, net, scopes)[: 8 if abi < 4 else 16 if abi < 6 else 24]
    libc = _libc()
    ruleset = _checked(
        libc.syscall(
            CREATE_RULESET, attributes, ctypes.c_size_t(len(attributes)), ctypes.c_uint32(0)
        )
    )
    try:
        for paths, wanted in ((read, READING), (write, rights & ~EXECUTE & ~IOCTL_DEV)):
            for path in paths:
                _allow_beneath(ruleset, path, wanted & rights)
        _no_new_privileges()
        _checked(libc.syscall(RESTRICT_SELF, ctypes.c_int(ruleset), ctypes.c_uint32(0)))
    finally:
        os.close(ruleset)


def _allow_beneath(ruleset: int, path: Path, rights: int) -> None:
    try:
        descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return  # what isn't there needs no rule
    try:
        if not stat.S_ISDIR(os.fstat(descriptor).st_mode):
            rights &= OF_FILES
        rule = struct.pack("<Qi", rights, descriptor)
        _checked(
            _libc().syscall(ADD_RULE, ctypes.c_int(ruleset), ctypes.c_int(PATH_BENEATH), rule, 0)
        )
    finally:
        os.close(descriptor)


# --- seccomp -------------------------------------------------------------------------------------

ARCHITECTURES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}  # AUDIT_ARCH, column
NONE = -1  # this architecture doesn't have the call
CALLS = {  # name: number on x86_64, on arm64
    "accept": (43, 202), "accept4": (288, 242), "acct": (163, 89), "add_key": (248, 217),
    "adjtimex": (159, 171), "bpf": (321, 280), "chroot": (161, 51),
    "clock_adjtime": (305, 266), "clock_settime": (227, 112),
    "delete_module": (176, 106), "execve": (59, 221), "execveat": (322, 281),
    "fanotify_init": (300, 262), "finit_module": (313, 273), "fork": (57, NONE),
    "fsconfig": (431, 431), "fsmount": (432, 432), "fsopen": (430, 430), "fspick": (433, 433),
    "init_module": (175, 105),
    "inotify_add_watch": (254, 27), "inotify_init": (253, NONE), "inotify_init1": (294, 26),
    "io_uring_enter": (426, 426), "io_uring_register": (427, 427), "io_uring_setup": (425, 425),
    "ioperm": (173, NONE), "iopl": (172, NONE),
    "kcmp": (312, 272), "kexec_file_load": (320, 294), "kexec_load": (246, 104),
    # more layers: rules are memory that no limit counts, and a filter may fill the machine's log
    "landlock_add_rule": (445, 445), "landlock_create_ruleset": (444, 444),
    "landlock_restrict_self": (446, 446), "seccomp": (317, 277),
    "keyctl": (250, 219), "listen": (50, 201), "listmount": (458, 458),
    "lookup_dcookie": (212, 18), "mbind": (237, 235), "memfd_create": (319, 279),
    "memfd_secret": (447, 447),  # memory that neither RLIMIT_DATA nor the judge's looks count
    "migrate_pages": (256, 238), "modify_ldt": (154, NONE),
    "mount": (165, 40), "mount_setattr": (442, 442), "move_mount": (429, 429),
    "move_pages": (279, 239), "mq_open": (240, 180), "mq_unlink": (241, 181),
    "msgctl": (71, 187), "msgget": (68, 186), "msgrcv": (70, 188), "msgsnd": (69, 189),
    "name_to_handle_at": (303, 264), "open_by_handle_at": (304, 265), "open_tree": (428, 428),
    "perf_event_open": (298, 241), "personality": (135, 92), "pidfd_getfd": (438, 438),
    "pidfd_open": (434, 434), "pidfd_send_signal": (424, 424), "pivot_root": (155, 41),
    "process_madvise": (440, 440), "process_mrelease": (448, 448),
    "process_vm_readv": (310, 270), "process_vm_writev": (311, 271), "ptrace": (101, 117),
    "quotactl": (179, 60), "quotactl_fd": (443, 443), "reboot": (169, 142),
    "request_key": (249, 218),
    "rt_sigqueueinfo": (129, 138), "rt_tgsigqueueinfo": (297, 240),
    "semctl": (66, 191), "semget": (64, 190), "semop": (65, 193), "semtimedop": (220, 192),
    "setdomainname": (171, 162), "sethostname": (170, 161),
    "setns": (308, 268), "setpgid": (109, 154), "setsid": (112, 157),
    "settimeofday": (164, 170), "shmat": (30, 196), "shmctl": (31, 195), "shmget": (29, 194),
    "statmount": (457, 457), "swapoff": (168, 225), "swapon": (167, 224),
    "syslog": (103, 116), "tkill": (200, 130),
    "truncate": (76, 45),  # by path, which Landlock minds only since ABI 3
    "umount2": (166, 39), "unshare": (272, 97),
    "uselib": (134, NONE), "userfaultfd": (323, 282), "vfork": (58, NONE), "vhangup": (153, 58),
}  # fmt: skip
PRETENDED = {  # to work: they reach what is others' past Landlock, and libraries use them
    "chmod": (90, NONE), "chown": (92, NONE), "fchmod": (91, 52), "fchmodat": (268, 53),
    "fchmodat2": (452, 452), "fchown": (93, 55), "fchownat": (260, 54), "fremovexattr": (199, 16),
    "fsetxattr": (190, 7), "futimesat": (261, NONE), "ioprio_set": (251, 30), "lchown": (94, NONE),
    "lremovexattr": (198, 15), "lsetxattr": (189, 6), "removexattr": (197, 14),
    "removexattrat": (466, 466), "sched_setaffinity": (203, 122), "sched_setattr": (314, 274),
    "sched_setparam": (142, 118), "sched_setscheduler": (144, 119), "setpriority": (141, 140),
    "setxattr": (188, 5), "setxattrat": (463, 463),
    "sync": (162, 81), "syncfs": (306, 267),  # of everybody's disk
    "utime": (132, NONE), "utimensat": (280, 88),
    "utimes": (235, NONE),
}  # fmt: skip
PRLIMIT = (302, 261)
MMAP = (9, 222)
PRCTL = (157, 167)
CLONE, CLONE3, KILL, TGKILL = (56, 220), (435, 435), (62, 129), (234, 131)
SOCKET, CONNECT, FCNTL, IOCTL = (41, 198), (42, 203), (72, 25), (16, 29)
OWNERSHIP = ((FCNTL, (8, 10, 15, 1026)), (IOCTL, (0x8901, 0x8902)))  # F_SETOWN …: signals by I/O
CLONE_THREAD = 0x00010000
OPENAT2, FALLOCATE = (437, 437), (285, 47)
X32_BIT = 0x40000000
AF_INET, AF_NETLINK, NETLINK_ROUTE = 2, 16, 0
SOCK_DGRAM, SOCK_TYPE = 2, 0xF

LOAD, AND, JUMP_EQUAL, JUMP_AT_LEAST, JUMP_SET, RETURN = 0x20, 0x54, 0x15, 0x35, 0x45, 0x06
ALLOW, REFUSE, KILL_PROCESS = 0x7FFF0000, 0x00050000, 0x80000000
# offsets in struct seccomp_data, of arguments the low halves
NUMBER, ARCHITECTURE, FIRST, SECOND, THIRD, FOURTH = 0, 4, 16, 24, 32, 40
MAP_SHARED, MAP_ANONYMOUS, MAP_GROWSDOWN = 0x01, 0x20, 0x0100

OPENING = ((SECOND, (2, NONE)), (THIRD, (257, 56)))  # open, openat: where the flags are

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, constant


def has_seccomp() -> bool:
    """Return whether this kernel filters system calls, and their numbers are known here."""
    strict_or_filter = _libc().prctl(PR_GET_SECCOMP, 0, 0, 0, 0)
    return strict_or_filter >= 0 and platform.machine() in ARCHITECTURES


def restrict_calls(*, datagrams: bool = False, reserving: bool = True) -> None:
    """Take away from this process what no node needs: sockets, programs, processes, others' memory.

    Threads go on to work, and so do signals to the process itself. Owners, modes and times of files
    and priorities stay as they are, though the calls seem to work. `datagrams` leaves it UDP,
    `reserving` the reservation of disk space, which takes gigabytes at once.

    Raises OSError: the kernel has no seccomp, or the architecture is another.
    """
    if platform.machine() not in ARCHITECTURES:
        raise OSError(errno.ENOSYS, f"no table of system calls for {platform.machine()}")
    program = _filter(datagrams, reserving)
    code = b"".join(struct.pack("HBBI", c, jt, jf, k) for c, jt, jf, k in program)
    instructions = ctypes.create_string_buffer(code, len(code))
    header = struct.pack("HxxxxxxQ", len(program), ctypes.addressof(instructions))
    filter_ = ctypes.create_string_buffer(header, len(header))
    _no_new_privileges()
    _checked(_libc().prctl(PR_SET_SECCOMP, 2, ctypes.c_void_p(ctypes.addressof(filter_)), 0, 0))


def _filter(datagrams: bool, reserving: bool) -> list[Instruction]:
    audit, column = ARCHITECTURES[platform.machine()]
    program: list[Instruction] = [
        (LOAD, 0, 0, ARCHITECTURE),
        (JUMP_EQUAL, 1, 0, audit),
        (RETURN, 0, 0, KILL_PROCESS),
        (LOAD, 0, 0, NUMBER),
    ]
    if column == 0:  # the x32 calls of x86_64 have other numbers
        program += [(JUMP_AT_LEAST, 0, 1, X32_BIT), _refuse(errno.ENOSYS)]
    for calls, error in ((CALLS, errno.EPERM), (PRETENDED, 0)):
        for numbers in calls.values():
            if numbers[column] != NONE:
                program += [(JUMP_EQUAL, 0, 1, numbers[column]), _refuse(error)]
    program += _only_if(CLONE[column], JUMP_SET, CLONE_THREAD)
    # glibc falls back to clone(), whose flags a filter can see
    program += [(JUMP_EQUAL, 0, 1, CLONE3[column]), _refuse(errno.ENOSYS)]
    # as on a kernel before 5.6: its flags lie where a filter can't see them
    program += [(JUMP_EQUAL, 0, 1, OPENAT2[column]), _refuse(errno.ENOSYS)]
    for number in (KILL[column], TGKILL[column]):  # abort() and raise() of the process itself
        program += _only_if(number, JUMP_EQUAL, os.getpid())
    for numbers, commands in OWNERSHIP:
        program += _unless(numbers[column], SECOND, commands)
    program += _only_if(PRLIMIT[column], JUMP_EQUAL, 0)  # its own
    program += _only_counted_memory(MMAP[column])
    # it ends with its judge, and adds no filter
    program += _unless(PRCTL[column], FIRST, (PR_SET_PDEATHSIG, PR_SET_SECCOMP))
    for place, numbers in OPENING:
        if numbers[column] != NONE:
            program += _unless_it_empties(numbers[column], place)
    if not reserving:  # glibc writes instead, which takes time
        program += [(JUMP_EQUAL, 0, 1, FALLOCATE[column]), _refuse(errno.EOPNOTSUPP)]
    program += _only_datagrams(column) if datagrams else _only_netlink(column)
    return [*program, (RETURN, 0, 0, ALLOW)]


def _refuse(error: int) -> Instruction:
    return (RETURN, 0, 0, REFUSE | error)


def _only_if(number: int, test: int, constant: int) -> list[Instruction]:
    """Refuse a call unless its first argument passes a test."""
    return [
        (JUMP_EQUAL, 0, 4, number),
        (LOAD, 0, 0, FIRST),
        (test, 1, 0, constant),
        _refuse(errno.EPERM),
        (LOAD, 0, 0, NUMBER),
    ]


def _only_counted_memory(number: int) -> list[Instruction]:
    """Refuse memory that RLIMIT_DATA doesn't count: shared without a file, or growing downward."""
    return [
        (JUMP_EQUAL, 0, 6, number),
        (LOAD, 0, 0, FOURTH),
        (JUMP_SET, 2, 0, MAP_GROWSDOWN),
        (JUMP_SET, 0, 2, MAP_ANONYMOUS),
        (JUMP_SET, 0, 1, MAP_SHARED),
        _refuse(errno.ENOMEM),
        (LOAD, 0, 0, NUMBER),
    ]


def _unless(number: int, place: int, constants: Collection[int]) -> list[Instruction]:
    """Refuse a call if an argument is one of these."""
    tests = [(JUMP_EQUAL, 0, 1, constant) for constant in constants]
    refusals = [step for test in tests for step in (test, _refuse(errno.EPERM))]
    load = [(JUMP_EQUAL, 0, 2 + len(refusals), number), (LOAD, 0, 0, place)]
    return [*load, *refusals, (LOAD, 0, 0, NUMBER)]


def _unless_it_empties(number: int, flags: int) -> list[Instruction]:
    """Refuse to empty a file by opening it for anything but writing.

    Before ABI 3 Landlock looks only at what the descriptor is for: a file that may be read could be
    emptied, and with the access mode 3, which means neither, any file at all.
    """
    return [
        (JUMP_EQUAL, 0, 7, number),
        (LOAD, 0, 0, flags),
        (JUMP_SET, 0, 4, os.O_TRUNC),
        (AND, 0, 0, os.O_ACCMODE),
        (JUMP_EQUAL, 2, 0, os.O_WRONLY),
        (JUMP_EQUAL, 1, 0, os.O_RDWR),
        _refuse(errno.EPERM),
        (LOAD, 0, 0, NUMBER),
    ]


def _only_netlink(column: int) -> list[Instruction]:
    """Refuse every socket but those that list network interfaces (Fast DDS asks at its start)."""
    return [
        (JUMP_EQUAL, 0, 1, CONNECT[column]),
        _refuse(errno.EPERM),
        (JUMP_EQUAL, 0, 6, SOCKET[column]),
        (LOAD, 0, 0, FIRST),
        (JUMP_EQUAL, 0, 2, AF_NETLINK),
        (LOAD, 0, 0, THIRD),
        (JUMP_EQUAL, 1, 0, NETLINK_ROUTE),
        _refuse(errno.EPERM),
        (LOAD, 0, 0, NUMBER),
    ]


def _only_datagrams(column: int) -> list[Instruction]:
    """Refuse every socket but UDP's and those that list network interfaces."""
    return [
        (JUMP_EQUAL, 0, 10, SOCKET[column]),
        (LOAD, 0, 0, FIRST),
        (JUMP_EQUAL, 0, 2, AF_NETLINK),
        (LOAD, 0, 0, THIRD),
        (JUMP_EQUAL, 5, 4, NETLINK_ROUTE),
        (JUMP_EQUAL, 0, 3, AF_INET),
        (LOAD, 0, 0, SECOND),
        (AND, 0, 0, SOCK_TYPE),
        (JUMP_EQUAL, 1, 0, SOCK_DGRAM),
        _refuse(errno.EPERM),
        (LOAD, 0, 0, NUMBER),
    ]


# --- both ----------------------------------------------------------------------------------------


def hide_memory() -> None:
    """Let no other process of the same user read or trace this one (nor its environment)."""
    _libc().prctl(PR_SET_DUMPABLE, 0, 0, 0, 0)


def die_with_parent(parent: int) -> None:
    """Be killed when the process that forked this one ends (a change of user takes that back)."""
    _libc().prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it has ended already
        os.kill(os.getpid(), signal.SIGKILL)


def _no_new_privileges() -> None:
    _checked(_libc().prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _checked(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return result
