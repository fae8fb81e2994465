"""docs/listing-style.md says what the grader says of its listings now."""

import pytest

from grader.authoring.listings import (
    BEGIN,
    END,
    HEAD,
    LISTINGS,
    NODES,
    PAGE,
    Listing,
    crucial_lines,
    section,
)

QUICK = ("front_by_index.py",)  # in `make test`


@pytest.mark.parametrize(
    ("number", "listing"),
    [
        pytest.param(
            number,
            listing,
            id=listing.file.removesuffix(".py"),
            marks=() if listing.file in QUICK else pytest.mark.long,
        )
        for number, listing in enumerate(LISTINGS, 1)
    ],
)
def test_the_page_has_the_score_and_every_message(number: int, listing: Listing) -> None:
    assert section(number, listing) in PAGE.read_text("utf-8")


def test_the_page_is_made_of_nothing_else() -> None:
    page = PAGE.read_text("utf-8")
    assert page.startswith(HEAD)
    assert page.count("\n## ") == len(LISTINGS)


def test_every_listing_is_on_the_page() -> None:
    assert {file.name for file in NODES.glob("*.py")} == {listing.file for listing in LISTINGS}


@pytest.mark.parametrize("listing", LISTINGS, ids=lambda listing: listing.file)
def test_the_crucial_lines_are_those_between_the_marks(listing: Listing) -> None:
    source = (NODES / listing.file).read_text("utf-8")
    assert source.count(BEGIN) == source.count(END) == 1
    lines = crucial_lines(NODES / listing.file)
    assert lines and not lines.startswith(" ")
    assert all(line.strip() in source for line in lines.splitlines())
