"""The desk as a browser without scripts meets it: the real command, its pages and its forms."""

import contextlib
import http.client
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urlencode, urlsplit

import pytest


@contextlib.contextmanager
def open_desk(out: Path, *names: str) -> Iterator[dict[str, str]]:
    """Run `course desk`; return the address of each person."""
    pytest.importorskip("tornado", reason="needs the extra `desk`")
    command = [sys.executable, "-m", "grader.cli", "desk", str(out)]
    command += [part for name in names for part in ("--for", name)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        found = {}
        for line in process.stdout:
            if line.startswith("Ctrl-C"):
                break
            name, _, address = line.strip().partition(": ")
            found[name] = address
        try:
            yield {name: found[name] for name in names}
        finally:
            process.terminate()


class Forms(HTMLParser):
    """The forms of a page: what is hidden in each, and each field with its values."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.forms: list[list[tuple[str, str]]] = []
        self.every: list[dict[str, list[str]]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = {name: value or "" for name, value in attrs}
        if tag == "form":
            self.forms.append([])
            self.every.append({})
        elif tag in ("input", "select", "textarea", "button") and self.forms and "name" in said:
            self.every[-1].setdefault(said["name"], []).append(said.get("value", ""))
            if said.get("type") == "hidden":
                self.forms[-1].append((said["name"], said.get("value", "")))


class Visitor:
    """One person at the desk."""

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        self.host, self.cookie = parts.netloc, ""
        status, headers, _ = self.ask("GET", f"{parts.path}?{parts.query}")
        assert status == 200
        self.set_cookie = headers["Set-Cookie"]
        self.cookie = self.set_cookie.partition(";")[0]

    def ask(
        self, method: str, path: str, body: str | bytes | None = None, **headers: str | None
    ) -> tuple[int, http.client.HTTPMessage, str]:
        sent = {"Host": self.host, "Cookie": self.cookie or None}
        if method == "POST":
            sent |= {"Origin": f"http://{self.host}",
                     "Content-Type": "application/x-www-form-urlencoded"}  # fmt: skip
        sent |= {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection(self.host, timeout=60)
        with contextlib.closing(connection):
            connection.request(method, path, body, {k: v for k, v in sent.items() if v})
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read().decode()

    def page(self, path: str) -> str:
        status, _, html = self.ask("GET", path)
        assert status == 200, html
        return html

    def send(self, html: str, wanted: Mapping[str, str], **typed: str | list[str]) -> str:
        """Send the page's form with these hidden fields; return the next page."""
        return self.sent(html, wanted, **typed)[2]

    def sent(
        self, html: str, wanted: Mapping[str, str], **typed: str | list[str]
    ) -> tuple[int, http.client.HTTPMessage, str]:
        form = next(each for each in Forms(html).forms if wanted.items() <= dict(each).items())
        form = [*form, *((name, text) for name, texts in typed.items()
                         for text in ([texts] if isinstance(texts, str) else texts))]  # fmt: skip
        return self.ask("POST", "/change", urlencode(form))


def words(html: str) -> str:
    """Return what a page says."""
    body = html.partition("<body>")[2]
    return " ".join(re.sub(r"<[^>]+>", " ", body).split())
