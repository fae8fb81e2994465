"""A page of HTML as tests read it."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """The text of a page, and its elements."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: list[str] = []  # those of scripts and style sheets, too
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []  # element, name, value
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
