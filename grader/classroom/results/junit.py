"""All gradings as JUnit XML, for any tool that shows test results.

Source: the schema of the Apache Ant JUnit task ("JUnit.xsd"), inside `testsuites`. A suite is one
student's exercise, a case is a check. Characters that XML 1.0 forbids are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree as ET

from grader.classroom.results.clean import one_line, visible
from grader.classroom.results.marks import (
    TO_HOLD,
    Check,
    Task,
    checks_of,
    is_absent,
    is_held,
    why_held,
)
from grader.classroom.row import ABSENT, StoredResult
from grader.report.terminal import SKIPPED

FACTS = ("expected", "actual", "where", "log", "help")


def junit_xml(results: Sequence[StoredResult], tasks: Sequence[Task]) -> str:
    """Return the document."""
    order = {task.slug: index for index, task in enumerate(tasks)}
    suites = [
        _suite(result)
        for result in sorted(results, key=lambda result: (order[result.exercise], result.student))
    ]
    root = ET.Element("testsuites", _totals(suites))
    root.extend(suites)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, "unicode") + "\n"


def _suite(result: StoredResult) -> ET.Element:
    name = f"{one_line(result.student)} / {one_line(result.exercise)}"
    cases = [_case(check, result) for check in checks_of(result)]
    if is_held(result) and not any(case.find("error") is not None for case in cases):
        held = ET.Element("testcase", classname=_class(result), name="graded", time="0")
        reason = why_held(result).reason
        ET.SubElement(held, "error", message=reason, type="held").text = reason
        cases.append(held)
    if is_absent(result):
        nothing = ET.Element("testcase", classname=_class(result), name="graded", time="0")
        ET.SubElement(nothing, "skipped", message=ABSENT)
        cases.append(nothing)
    attributes = {
        "name": name,
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
        "skipped": str(sum(case.find("skipped") is not None for case in cases)),
        "time": f"{max(0.0, result.wall_s):.3f}",
    }
    if result.finished:
        attributes["timestamp"] = one_line(result.finished)
    suite = ET.Element("testsuite", attributes)
    suite.extend(cases)
    if cause := (result.grading or {}).get("cause"):
        ET.SubElement(suite, "system-out").text = f"cause: {visible(str(cause.get('text', '')))}"
    return suite


def _case(check: Check, result: StoredResult) -> ET.Element:
    name = one_line(check.get("id") or "check")
    case = ET.Element("testcase", classname=_class(result), name=name, time="0")
    outcome = str(check.get("outcome"))
    if outcome == "pass":
        return case
    kind = "skipped" if outcome in SKIPPED else "error" if outcome in TO_HOLD else "failure"
    message = one_line(check.get("message") or check.get("title") or outcome, 500)
    child = ET.SubElement(case, kind, message=message)
    if kind != "skipped":
        child.set("type", outcome)
        lines = [visible(check.get("title") or ""), visible(check.get("message") or "")]
        lines += [f"{key}: {visible(check[key])}" for key in FACTS if check.get(key)]
        child.text = "\n".join(line for line in lines if line)
    return case


def _class(result: StoredResult) -> str:
    return f"{one_line(result.exercise)}.{one_line(result.student).replace('.', '_')}"


def _totals(suites: Sequence[ET.Element]) -> dict[str, str]:
    keys = ("tests", "failures", "errors", "skipped")
    totals = {key: str(sum(int(suite.get(key, "0")) for suite in suites)) for key in keys}
    totals["time"] = f"{sum(float(suite.get('time', '0')) for suite in suites):.3f}"
    return {"name": "course", **totals}
