"""A notebook's judge: a process beside the kernel that drives and grades as `course` does.

The kernel runs whatever a student writes, so nothing is judged in it. This process reads orders
from stdin, keeps its fork servers warm between them, and ends when the kernel does.
"""

import contextlib
import io
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import BinaryIO

import msgspec

from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.drive import (
    arguments_of,
    check_moments,
    drive_in,
    drive_node,
    print_moments,
    print_summary,
    scenario_for,
    search,
    unpacked,
)
from grader.errors import GraderError, InputError
from grader.grading.grading import grade_submission
from grader.launchers import ForkServerPool, launcher_pool
from grader.notebook import orders
from grader.notebook.answers import graded
from grader.report.page import page_html, page_payload
from rclpy_virtual_time import Launcher, Link

GRACE = 5.0  # [s] for an interrupted order to clean up

Send = Callable[[orders.Answer], None]


def main() -> None:
    """Carry out orders until the kernel closes the pipe."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # prints go to stderr
    waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(sys.stdin.buffer, waiting), daemon=True).start()
    send = _sender(answers)
    with contextlib.suppress(KeyboardInterrupt, BrokenPipeError), launcher_pool() as forkservers:
        while line := waiting.get():
            order = msgspec.json.decode(line, type=orders.Order)
            answer = carry_out(order, forkservers, send)
            if answer is not None:
                send(answer)


def carry_out(order: orders.Order, forkservers: ForkServerPool, send: Send) -> orders.Answer | None:
    """Carry out an order and return the answer; `orders.Warm` has none."""
    try:
        match order:
            case orders.Warm():
                forkservers.of(order.libraries)
                return None
            case orders.Drive():
                able = (*order.libraries, *([Link.Moment.LIBRARY] if order.at else []))
                return _drive(order, forkservers.of(able))
            case orders.Grade():
                return _grade(order, forkservers, send)
            case orders.Look():
                return _look(order, forkservers, send)
    except InputError as error:
        return None if isinstance(order, orders.Warm) else orders.Problem(str(error))
    except GraderError as error:
        forkservers.close()
        return None if isinstance(order, orders.Warm) else orders.Problem(str(error), fault=True)


def _drive(order: orders.Drive, launcher: Launcher) -> orders.Driven:
    scenario = scenario_for(
        order.scenario, lidar=order.lidar, duration=order.duration, goals=order.goals
    )
    check_moments(order.at, scenario)
    others = [program.file for program in scenario.program if program.file]
    submission = find_submission(Path(order.file), others=others)
    submission = unpacked(submission, launcher)
    arguments = arguments_of(order.params)
    recording = drive_node(
        submission, scenario, launcher, seed=order.seed, arguments=arguments,
        look=order.at, on_second_look=lambda: None,
    )  # fmt: skip
    with contextlib.redirect_stdout(io.StringIO()) as said:
        print_summary(recording, file=order.shown, seed=order.seed, practice=launcher.practice)
        print(*(f"  {sentence}" for sentence in submission.account()), sep="\n")
        print_moments(recording, order.at, order.callback)
    payload = page_payload(None, [recording], recording.scenario.title or recording.name)
    return orders.Driven(said.getvalue(), page_html({**payload, "embedded": True}))


def _look(order: orders.Look, forkservers: ForkServerPool, send: Send) -> orders.Driven:
    exercise = find_exercise(order.exercise)
    arena = search.arena_of(exercise, field=order.field)
    submission = find_submission(Path(order.file), exercise.files[0])
    launcher = forkservers.of(exercise.libraries)
    result = search.search(
        arena,
        lambda scenario: drive_in(submission, scenario, launcher),
        seed=order.seed,
        tries=order.tries,
        minutes=order.minutes,
        on_try=lambda tries, so_far: send(
            orders.Progressed("world", tries, order.tries or 0, so_far)
        ),
    )
    said = result.account(exercise=exercise.number, seed=order.seed)
    if result.found is None:
        return orders.Driven(said, "")
    found = result.found
    payload = page_payload(None, [found.recording], found.sentence, found.mishap.at)
    return orders.Driven(said, page_html({**payload, "embedded": True}))


def _grade(order: orders.Grade, forkservers: ForkServerPool, send: Send) -> orders.Graded:
    exercise = find_exercise(order.exercise)
    path = Path(order.file)
    submission = find_submission(path, exercise.files[0], exercise.files[1:])
    grading = grade_submission(
        exercise,
        submission,
        forkservers.of(exercise.libraries),
        file=order.shown,
        field=order.field,
        only=order.only,
        on_progress=lambda step: send(orders.Progressed(*step)),
    )
    return graded(grading, path)


def _sender(file: BinaryIO) -> Send:
    lock = threading.Lock()  # trials report from several threads

    def send(answer: orders.Answer) -> None:
        line = memoryview(msgspec.json.encode(answer) + b"\n")
        with lock:
            while line:
                line = line[os.write(file.fileno(), line) :]

    return send


def _read(lines: Iterable[bytes], waiting: queue.SimpleQueue[bytes]) -> None:
    """Queue orders; when there are no more, interrupt the running one and end this process."""
    for line in lines:
        waiting.put(line)
    waiting.put(b"")
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(GRACE)
    os._exit(1)


if __name__ == "__main__":
    main()
