"""Pages of synthetic payloads in a real Chromium."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from grader.report.page import page_html


@pytest.fixture
def open_page(open_file: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """Open a payload's page."""

    def open_(payload: dict[str, Any], **options: Any) -> Any:
        file = tmp_path / "report.html"
        file.write_text(page_html(payload), encoding="utf-8")
        return open_file(file, **options)

    return open_
