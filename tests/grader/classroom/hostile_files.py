"""Files that were made to hurt whoever reads them, by what is tried; each is small on the disk.

Bombs, links, locked and broken archives of the plainest kind are in test_intake.py.
"""

import gzip
import io
import json
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Callable

AGENT = "obstacle_avoidance_agent.py"
MIB = 2**20


def _zip(*members: tuple[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name), data, method)
    return file.getvalue()


def _bomb(method: int, size: int = 1) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive, archive.open(AGENT, "w") as member:
        for _ in range(size):
            member.write(bytes(MIB))
    return file.getvalue()


def _lying_method() -> bytes:
    """Return a zip that says "stored" in one place and "bzip2" in the other."""
    data = bytearray(_bomb(zipfile.ZIP_BZIP2))
    central = data.rindex(b"PK\x01\x02")
    data[central + 10 : central + 12] = struct.pack("<H", zipfile.ZIP_DEFLATED)
    return bytes(data)


def _many_names(count: int, length: int = 8) -> bytes:
    """Return a zip whose directory has so many entries, all of one empty file."""
    local = struct.pack("<IHHHHHIIIHH", 0x04034B50, 20, 0, 0, 0, 0x21, 0, 0, 0, 1, 0) + b"x"
    entries = []
    for number in range(count):
        name = f"{number:0{length}d}".encode()
        head = (0x02014B50, 20, 20, 0, 0, 0, 0x21, 0, 0, 0, len(name), 0, 0, 0, 0, 0, 0)
        entries.append(struct.pack("<IHHHHHHIIIHHHHHII", *head) + name)
    central = b"".join(entries)
    most = min(count, 0xFFFF)
    end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, most, most, len(central), len(local), 0)
    return local + central + end


def _overlapping() -> bytes:
    """Return a zip with 4,000 entries for the same 2 MiB of zeros."""
    zeros = bytes(2 * MIB)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(zeros) + packer.flush()
    check, size = zlib.crc32(zeros), len(zeros)
    head = (0x04034B50, 20, 0, 8, 0, 0x21, check, len(packed), size, 1, 0)
    local = struct.pack("<IHHHHHIIIHH", *head) + b"x" + packed
    entry = struct.pack(
        "<IHHHHHHIIIHHHHHII", 0x02014B50, 20, 20, 0, 8, 0, 0x21, check, len(packed), size, 1,
        0, 0, 0, 0, 0, 0,
    ) + b"x"  # fmt: skip
    central = entry * 4_000
    end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, 4_000, 4_000, len(central), len(local), 0)
    return local + central + end


def _broken_offset() -> bytes:
    data = bytearray(_zip((AGENT, b"x = 1\n")))
    central = data.rindex(b"PK\x01\x02")
    data[central + 42 : central + 46] = b"\xff\xff\xff\x7f"
    return bytes(data)


def _tar(*members: tarfile.TarInfo | tuple[str, bytes], form: int = tarfile.PAX_FORMAT) -> bytes:
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w", format=form) as archive:
        for member in members:
            if isinstance(member, tarfile.TarInfo):
                archive.addfile(member)
                continue
            info = tarfile.TarInfo(member[0])
            info.size = len(member[1])
            archive.addfile(info, io.BytesIO(member[1]))
    return gzip.compress(file.getvalue())


def _pax(body: bytes, kind: bytes = tarfile.XHDTYPE) -> bytes:
    head = tarfile.TarInfo("x")
    head.type, head.size = kind, len(body)
    packed = head.tobuf(tarfile.USTAR_FORMAT) + body + bytes(-len(body) % 512)
    file = tarfile.TarInfo(AGENT).tobuf(tarfile.USTAR_FORMAT)
    return gzip.compress(packed + file + bytes(1024))


def _special(kind: bytes, target: str = "") -> tarfile.TarInfo:
    info = tarfile.TarInfo(AGENT)
    info.type, info.linkname = kind, target
    return info


def _headers(count: int) -> bytes:
    one = tarfile.TarInfo("x").tobuf(tarfile.USTAR_FORMAT)
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    return b"".join(packer.compress(one * 1000) for _ in range(count // 1000)) + packer.flush()


def _endless_gzip() -> bytes:
    return gzip.compress(b"") * 200_000


def _sparse() -> bytes:
    """Return a tar with an old GNU sparse file of a terabyte, in 512 bytes."""
    info = tarfile.TarInfo(AGENT)
    info.type, info.size = tarfile.GNUTYPE_SPARSE, 0
    head = bytearray(info.tobuf(tarfile.GNU_FORMAT))
    head[386:410] = b"00000000000\0" + b"00000000000\0"
    head[483:495] = b"\x80\0\0\0\0\0\x01\0\0\0\0\0"
    head[148:156] = b" " * 8
    head[148:156] = b"%06o\0 " % sum(head)
    return gzip.compress(bytes(head) + bytes(1024))


def _notebook(source: object, **more: object) -> bytes:
    cell = {"cell_type": "code", "metadata": {}, "source": source} | more
    return json.dumps({"nbformat": 4, "cells": [cell]}).encode()


NODE = f"%%node {AGENT}\n"
# each key merges the one before it twice
MERGED = b"a0: &a0 {x: 1}\n" + b"".join(
    b"a%d: &a%d {<<: [*a%d, *a%d]}\n" % (n, n, n - 1, n - 1) for n in range(1, 40)
)
# name: suffix, what is in it, the problem that is told ("": none; its work is taken as it is)
FILES: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "bzip2 bomb": (".zip", lambda: _bomb(zipfile.ZIP_BZIP2), "rare method"),
    "LZMA bomb": (".zip", lambda: _bomb(zipfile.ZIP_LZMA), "rare method"),
    "bomb with another method inside": (".zip", _lying_method, "broken"),
    "a million entries": (".zip", lambda: _many_names(1_000_000), "CPU time|files; not"),
    "entries of long names": (".zip", lambda: _many_names(4_000, 60_000), "broken|512 MiB"),
    "overlapping entries": (".zip", _overlapping, ""),
    "wild offset": (".zip", _broken_offset, "broken archive"),
    "nested zips": (".zip", lambda: _zip(("a.zip", _zip(("b.zip", _zip((AGENT, b"")))))), ""),
    "Gradescope's metadata, endless": (
        ".zip", lambda: _zip((AGENT, b"x"), ("a/submission_metadata.yml", MERGED)), ""),
    "the same, above all": (
        ".zip", lambda: _zip((AGENT, b"x"), ("submission_metadata.yml", MERGED)), "of several"),
    "a drive of Windows": (".zip", lambda: _zip(("C:evil.py", b"x")), "points outside"),
    "bidi and escapes": (".zip", lambda: _zip((f"\u202e\x1b[2J/{AGENT}", b"x=1\n")), ""),
    "CRLF in a name": (".zip", lambda: _zip((f"a\r\nb: c/{AGENT}", b"x=1\n")), ""),
    "NUL in a name": (".zip", lambda: _zip(("aXb.py", b"x")).replace(b"aXb", b"a\0b"), ""),
    "name too long": (".zip", lambda: _zip(("x" * 5_000 + ".py", b"x")), "too long"),
    "file and folder": (".zip", lambda: _zip(("a", b"x"), ("a/b.py", b"x")), "broken"),
    "digits (CVE-2024-6232)": (".tgz", lambda: _pax(b"1" * 400_000), "CPU time|^$"),
    "digits, global": (".tgz", lambda: _pax(b"1" * 400_000, tarfile.XGLTYPE), "CPU time|^$"),
    "negative size": (".tgz", lambda: _pax(b"11 size=-1\n"), ""),
    "huge size": (".tgz", lambda: _pax(b"30 size=99999999999999999999\n"), "broken"),
    "a header of a gigabyte": (".tgz", lambda: gzip.compress(_pax_head(2**30)), "broken"),
    "surrogate name": (".tgz", lambda: _tar((f"\udcff/{AGENT}", b"x=1\n")), ""),
    "thousands of headers": (".tgz", lambda: _headers(7_000), "files; not unpacked"),
    "empty gzip members": (".tgz", _endless_gzip, "broken|CPU"),
    "sparse terabyte": (".tgz", _sparse, "far larger"),
    "symbolic link": (".tgz", lambda: _tar(_special(tarfile.SYMTYPE, "/etc/passwd")), ""),
    "device": (".tgz", lambda: _tar(_special(tarfile.CHRTYPE)), ""),
    "deep JSON": (".ipynb", lambda: b'{"cells": ' + b"[" * 400_000, "not JSON"),
    "many brackets": (".ipynb", lambda: b'{"cells": [' + b"{}," * 600_000 + b"{}]}", "more parts"),
    "huge number": (".ipynb", lambda: b'{"cells": ' + b"1" * 1_000_000 + b"}", "not JSON"),
    "emoji": (".ipynb", lambda: _notebook("\U0001f600" * 9 * MIB).replace(b"\\ud83d\\ude00",
              "\U0001f600".encode()), ""),
    "lone surrogate": (".ipynb", lambda: _notebook(NODE + "x = '\ud800'\n"), ""),
    "a thousand modules": (".ipynb", lambda: json.dumps({"cells": [
        {"cell_type": "code", "source": f"%%node m{n}.py\nx = {n}\n"} for n in range(1_500)]
    }).encode(), ""),
    "a path as a module": (".ipynb", lambda: _notebook("%%node ../../evil.py\nx = 1\n"), ""),
    "no notebook": (".ipynb", lambda: b"\xff\xfe\x00", "not JSON"),
}  # fmt: skip


def _pax_head(size: int) -> bytes:
    head = tarfile.TarInfo("x")
    head.type, head.size = tarfile.XHDTYPE, size
    return head.tobuf(tarfile.USTAR_FORMAT) + bytes(4096)
