"""How large the report of a big class is, how long it takes to write, to open and to change marks.

    python benchmarks/class_of.py GRADED --students 500

makes a class of the stored gradings in GRADED, which `course autograde` has written, and grades
nobody. Pages have no replays, which are as large as ever (about 1 MB a student).
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from grader.classroom.amendments import Late, Score, Undo, Waive, Whom  # noqa: E402
from grader.classroom.folder import STORE, opened, write_class  # noqa: E402
from grader.classroom.marking import marking  # noqa: E402
from grader.classroom.results.kept import OPTIONS, kept_options, kept_text  # noqa: E402
from grader.classroom.results.marks import checks_of  # noqa: E402
from grader.classroom.row import StudentRow  # noqa: E402
from grader.classroom.store import Store  # noqa: E402

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
REPEATS = 5


def made(source: Path, out: Path, students: int) -> list[tuple[str, str]]:
    """Store a class of so many students; return exercises with a check each."""
    with opened(source) as store:
        graded = [one for one in store.results() if one.grading and not one.canary]
        options = kept_options(store.kept(OPTIONS), store.students())
    slugs = sorted({one.exercise for one in graded})
    rows = []
    with Store(out / STORE) as store:
        for number in range(students):
            name = f"student-{number:04}"
            rows.append(StudentRow(name, f"Student {number}", section=f"Section {number % 8}"))
            for slug in slugs:
                of_it = [one for one in graded if one.exercise == slug]
                one = of_it[number % len(of_it)]
                store.enter((name, slug), one.input_hash)
                store.claim((name, slug), one.input_hash, one.file_names)
                store.finish((name, slug), one.grading, cpu_s=one.cpu_s, wall_s=one.wall_s)
                store.verify([(name, slug)])
        store.know(rows)
        store.keep(OPTIONS, kept_text(replace(options, notes=[], workers=2)))
    return [(slug, str(checks_of(next(o for o in graded if o.exercise == slug))[0]["id"]))
            for slug in slugs]  # fmt: skip


def timed(what: str, do: Callable[[], Any]) -> None:
    """Print how long something takes, and how long it computes."""
    start, cpu = time.perf_counter(), time.process_time()
    do()
    took, computed = time.perf_counter() - start, time.process_time() - cpu
    print(f"{what:42} {took:8.1f} s, {computed:.1f} s of CPU")


def marked(out: Path, change: Any) -> None:
    """Change a mark."""
    with marking(out) as class_:
        class_.add(change, "benchmark", "to measure it")


def opening(page: Path) -> str:
    """Return how long Chromium takes to load and lay out a page, the median."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    found = next(filter(None, map(shutil.which, CHROMIUM)))
    times = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        for _ in range(REPEATS):
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            start = time.perf_counter()
            tab.goto(page.as_uri())
            tab.evaluate("document.body.getBoundingClientRect().height")
            times.append(time.perf_counter() - start)
            tab.close()
        browser.close()
    return f"{sorted(times)[REPEATS // 2]:.2f} s"


def main() -> None:
    """Measure one class."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("graded", type=Path)
    parser.add_argument("--students", type=int, default=500)
    told = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        exercises = made(told.graded, out, told.students)
        print(f"{told.students} students, {len(exercises)} exercises")
        with opened(out) as store:
            options = kept_options(store.kept(OPTIONS), store.students())
            timed("all results, the first time", lambda: write_class(store, out, options))
            timed("all results again", lambda: write_class(store, out, options))
        slug, check = exercises[0]
        timed("marks score, one student", lambda: marked(
            out, Score(slug, 1, Whom(("student-0001",)))))  # fmt: skip
        timed("marks waive, everybody", lambda: marked(out, Waive(slug, check)))
        timed("marks undo, everybody", lambda: marked(out, Undo(2)))
        timed("marks late, everybody", lambda: marked(
            out, Late(slug, 10, "2026-05-04T00:00+00:00")))  # fmt: skip
        pages = [out / "class.html", *sorted((out / "sections").glob("*.html"))[:1]]
        largest = sorted(out.glob("checks/*/*.html"), key=lambda page: page.stat().st_size)
        for page in [*pages, *largest[-1:]]:
            size = page.stat().st_size / 1000
            print(f"{page.relative_to(out).as_posix():42} {size:8.0f} kB  opens in {opening(page)}")


if __name__ == "__main__":
    main()
