"""What the terminal says of a class: who handed in what, and what a batch came to."""

import statistics
from pathlib import Path

from grader.classroom.account import many
from grader.classroom.batch import GradedClass
from grader.classroom.intake.candidates import Class
from grader.classroom.row import ABSENT, GRADED, HELD, WAITING

MOST_HELD = 20  # lines at the end


def summary(graded_class: GradedClass, out: Path) -> tuple[str, int]:
    """Return what the instructor reads at the end, and how many things wait for a person."""
    ours = graded_class.results
    held = [result for result in ours if result.state == HELD]
    graded = sum(result.state == GRADED for result in ours)
    absent = sum(result.state == ABSENT for result in ours)
    waiting = [result for result in ours if result.state == WAITING]
    counts = f"{graded} graded, {len(held)} held for a person"
    counts += f", {absent} not handed in" if absent else ""
    counts += f", {len(waiting)} not graded yet" if waiting else ""
    lines = [f"{counts}. Open {out / 'class.html'}"]
    took = [result.wall_s for result in ours if result.state == GRADED and result.wall_s]
    if took:
        lines.append(
            f"A grading took {statistics.median(took):.1f} s (median), all together "
            f"{sum(took) / 60:.1f} min on one worker."
        )
    if waiting:
        lines.append("  The same command without --regrade and --exercise grades the rest.")
    for one in held[:MOST_HELD]:
        problem = " ".join(one.problem.split())
        lines.append(f"  held: {one.student}  {one.exercise}  {problem}")
    if len(held) > MOST_HELD:
        lines.append(f"  and {len(held) - MOST_HELD} more, in the class report")
    faults = graded_class.account.summary()
    if faults:
        lines += ["Not all that was handed in was understood:", *faults]
    missing = graded_class.missing
    if missing:
        lines.append("The grader could not write all of it. Missing, as the class report says:")
        lines += [f"  missing: {each}" for each in missing[:MOST_HELD]]
    if len(missing) > MOST_HELD:
        lines.append(f"  and {len(missing) - MOST_HELD} more, in the class report")
    return "\n".join(lines), len(held) + len(waiting) + len(graded_class.account.faults)


def listing(found: Class) -> tuple[str, int]:
    """Return who handed in what, for the terminal, and how many things wait for a person."""
    by_student: dict[str, list[str]] = {}
    held: dict[str, str] = {}  # a line: the first exercise is enough
    for (student, slug), candidate in found.candidates.items():
        files = by_student.setdefault(student, [])
        if candidate.absent:
            continue
        _, trouble = candidate.read()
        files.append(f"{slug} (will be held)" if trouble else slug)
        if trouble:
            held.setdefault(f"  will be held: {student}  {' '.join(trouble.split())}", slug)
    names = {row.student: row for row in found.students}
    lines = []
    for student, slugs in sorted(by_student.items()):
        row = names.get(student)
        known = (row.person.label, row.person.section) if row else ()
        about = ", ".join(each for each in known if each and each != student)
        lines.append(
            f"{student}{f' ({about})' if about else ''}: {', '.join(slugs) or 'nothing handed in'}"
        )
    counts = "; ".join(f"{state}: {count}" for state, count in found.account.counts().items())
    lines.append(f"{many(len(by_student), 'student')}; {counts}.")
    listed = list(held)[:MOST_HELD]
    if len(held) > MOST_HELD:
        listed.append(f"  and {len(held) - MOST_HELD} more will be held")
    text = "\n".join([*lines, *listed, *found.account.summary()])
    return text, len(held) + len(found.account.faults)
