"""The desk's server: on this machine only, for those who have an address that it has printed.

A browser shows the desk beside pages of anybody's. So each request has to name this machine as its
host (no other name that leads here, as in DNS rebinding), a change has to come from the desk's own
page (Origin, and a token in the form that only this page has), and who asks is known by a cookie
that no other site's page can have sent (SameSite=Strict) and no script can read (HttpOnly). Pages
of students are served without the desk's origin (CSP: sandbox), whatever is in them.
"""

import asyncio
import secrets
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler

from grader.classroom.desk import pages
from grader.classroom.desk.forms import Form, Person
from grader.errors import GraderError, InputError

ADDRESS = "127.0.0.1"
HOSTS = (ADDRESS, "localhost")
MAX_BODY = 512 * 1024  # [bytes] of a form
THREADS = 4
LOG_IN = "/enter"
FROM_HERE = ("same-origin", "none")  # Sec-Fetch-Site; none: the person has typed it
SANDBOX = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data:; form-action 'none'; frame-ancestors 'self'"
)
HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",  # with no-referrer browsers send no Origin
    "Cache-Control": "no-store",
}
NOT_YOURS = "Open the desk with the address that the command has printed for you."


@dataclass
class Desk:
    """A class, and who may work on it."""

    out: Path
    keys: dict[str, str]  # of the printed addresses: whose
    people: dict[str, Person] = field(default_factory=dict)  # by cookie
    threads: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(THREADS))


class _Page(RequestHandler):
    def initialize(
        self, desk: Desk, make: Callable[..., pages.Html] = pages.refused, asked: Sequence[str] = ()
    ) -> None:  # fmt: skip
        self.desk, self.make, self.asked = desk, make, asked

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in HEADERS.items():
            self.set_header(name, value)

    @property
    def cookie(self) -> str:
        """The cookie's name: hosts have cookies, not ports, and there may be two desks."""
        return f"course-desk-{self.request.host.rpartition(':')[2]}"

    def prepare(self) -> None:
        """Refuse what doesn't come from a page of this desk.

        Raises HTTPError: it does not.
        """
        if self.request.host_name not in HOSTS:
            raise HTTPError(HTTPStatus.FORBIDDEN, reason="Another host")
        if self.request.path == LOG_IN:
            return
        if self.request.headers.get("Sec-Fetch-Site", "none") not in FROM_HERE:
            raise HTTPError(HTTPStatus.FORBIDDEN, reason="From another site")
        person = self.desk.people.get(self.get_cookie(self.cookie) or "")
        if person is None:
            raise HTTPError(HTTPStatus.FORBIDDEN, reason="Nobody known")
        self.person = person
        if self.request.method == "POST":
            here = f"http://{self.request.host}"
            token = self.get_body_argument("token", "")
            if self.request.headers.get("Origin") != here:
                raise HTTPError(HTTPStatus.FORBIDDEN, reason="From another page")
            if not secrets.compare_digest(token.encode(), person.token.encode()):
                raise HTTPError(HTTPStatus.FORBIDDEN, reason="An old form")

    async def answer(self, make: Callable[..., pages.Html], *about: Any) -> None:
        """Send a page, made in a thread; what a person can do about an error is a page, too."""
        loop = asyncio.get_running_loop()
        try:
            html = await loop.run_in_executor(
                self.desk.threads, make, self.desk.out, self.person, *about
            )
        except pages.Stale as error:
            self.set_status(HTTPStatus.CONFLICT)
            html = error.page
        except (InputError, GraderError, OSError) as error:
            busy = isinstance(error, GraderError)
            self.set_status(HTTPStatus.CONFLICT if busy else HTTPStatus.BAD_REQUEST)
            html = pages.refused(str(error))
        self.finish(html)

    def write_error(self, status_code: int, **_: Any) -> None:
        known = status_code in (HTTPStatus.FORBIDDEN, HTTPStatus.NOT_FOUND)
        reason = f"{self._reason}. " if known else "Something went wrong; nothing was written. "
        self.finish(pages.refused(reason + (NOT_YOURS if status_code == 403 else "")))


class _Enter(_Page):
    def get(self) -> None:
        key = self.get_query_argument("key", "")
        names = [name for each, name in self.desk.keys.items()
                 if secrets.compare_digest(each.encode(), key.encode())]  # fmt: skip
        if not names:
            raise HTTPError(HTTPStatus.FORBIDDEN, reason="Nobody known")
        cookie = secrets.token_urlsafe(32)
        self.desk.people[cookie] = Person(names[0], secrets.token_urlsafe(32))
        self.set_cookie(self.cookie, cookie, httponly=True, samesite="Strict", path="/")
        self.finish(pages.entered(names[0]))  # no redirect: after one from a mail it isn't sent


class _Shown(_Page):
    async def get(self, *about: str) -> None:
        asked = (self.get_query_argument(name, "") for name in self.asked)
        await self.answer(self.make, *about, *asked)


class _Replay(_Shown):
    def set_default_headers(self) -> None:
        super().set_default_headers()
        self.set_header("Content-Security-Policy", SANDBOX)
        self.clear_header("Cross-Origin-Opener-Policy")  # browsers show no page that has both


class _Change(_Page):
    async def post(self) -> None:
        await self.answer(pages.changed, Form.of(self.request.body_arguments, self.request.files))


class _Nothing(_Page):
    def prepare(self) -> None:
        super().prepare()
        raise HTTPError(HTTPStatus.NOT_FOUND)


def application(desk: Desk) -> Application:
    """Return the desk as a web application."""
    known: dict[str, Any] = {"desk": desk}
    shown = [
        ("/", pages.class_page, ("find", "section")), ("/held", pages.held_page, ()),
        ("/requests", pages.requests_page, ()), ("/marks", pages.marks_page, ()),
        ("/student/([^/]+)/([^/]+)", pages.student_page, ()),
    ]  # fmt: skip
    return Application(
        [
            *((path, _Shown, known | {"make": make, "asked": of}) for path, make, of in shown),
            ("/replay/([^/]+)/([^/]+)", _Replay, known | {"make": pages.replay}),
            (LOG_IN, _Enter, known), ("/change", _Change, known),
        ],
        default_handler_class=_Nothing, default_handler_args=known,
        log_function=lambda _: None,  # addresses have keys in them
    )  # fmt: skip


def serve(
    out: Path, names: Sequence[str], port: int, say: Callable[[dict[str, str]], None]
) -> None:
    """Serve a class until Ctrl-C; `say` gets the address of each person.

    Raises InputError: somebody else has the port.
    """
    asyncio.run(_serve(out, names, port, say))


async def _serve(
    out: Path, names: Sequence[str], port: int, say: Callable[[dict[str, str]], None]
) -> None:
    keys = {secrets.token_urlsafe(32): name for name in names}
    server = HTTPServer(application(Desk(out, keys)), max_buffer_size=MAX_BODY)
    try:
        sockets = bind_sockets(port, ADDRESS)
    except OSError as error:
        raise InputError(f"--port {port}: {error.strerror}; expected a free one, or 0") from None
    server.add_sockets(sockets)
    bound = sockets[0].getsockname()[1]
    say({name: f"http://{ADDRESS}:{bound}{LOG_IN}?key={key}" for key, name in keys.items()})
    await asyncio.Event().wait()
