"""The workspace in a real browser: the built site, from a plain server, below a sub-path.

Every other host leads nowhere. What is typed is driven and checked by the page; the verdicts are
those of `course grade`. Without `make workspace` these tests are skipped.
"""

import json
import subprocess
import sys
import zlib
from base64 import urlsafe_b64encode
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from served_site import SLOW, served, settle, type_in, typed

from grader.claims.mutants import find_mutant, mutants, submission_of
from grader.course.exercises import ROOT, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.trial.seeds import trial_seed
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario_files import load_scenario
from sim.simulation import Simulation
from workspace.build import PAGE_PACKAGES, lay, page_packages
from workspace.plan import plan

MADE = ROOT / "build" / "workspace" / "manifest.json"
TYPED = {  # after the reference; where nothing is said, the first three mutants
    "obstacle_avoidance": ("narrow_cone", "one_close_beam_is_noise", "reliable_only"),
    "ml_velocity": ("loads_twice", "front_is_90_degrees", "nan_slips_through"),
    "goal_seeking": ("yaw_in_degrees", "ignores_without_a_word", "no_wrap"),
    "trend_memory": ("whole_circle", "dies_of_equal_stamps", "time_of_arrival"),
    "slow_model": ("one_group_for_all", "thread_for_each_scan", "overlapping_inferences"),
    "model_server": ("dies_of_the_other_exceptions", "age_since_arrival", "constructor_waits"),
    "safety_supervisor": ("raises_on_nan", "no_obstacle", "silent_when_stale"),
    "model_formats": ("suffix_within", "features_in_another_order", "nan_slips_through"),
    "latency_monitor": ("all_calls_ever", "dies_without_a_model", "missed_ever"),
    "live_parameters": ("read_once", "narrow_cone", "each_by_itself"),
    "three_nodes": ("two_guards", "past_the_guard", "nan_gets_through"),
}
SLUG = "obstacle_avoidance"
RIGHT = (find_exercise(SLUG).solutions / "obstacle_avoidance_agent.py").read_text()
BOMB = zlib.compress(bytes(2**21))  # short; it unpacks to more than a link may
KEPT = """async () => {
  while (!await caches.match(location.pathname)) await new Promise(requestAnimationFrame);
}"""
NO_STORAGE = "Object.defineProperty(window, 'localStorage', { get() { throw new Error('no') } })"
SAID = """(all) => all.map((row) => [row.dataset.check,
  [row.dataset.outcome, row.querySelector('.ws-detail p')?.textContent || '']])"""
MEASURED = ("callback_time",)  # by the wall clock: a busy machine shows in it
WRECKS = """
import sys, threading
import rclpy.node, geometry_msgs.msg
threading.Thread(target=threading.Event().wait, daemon=True).start()
rclpy.node.Node.create_publisher = rclpy.spin_once = geometry_msgs.msg.Twist = None
sys.modules["rclpy"] = sys.modules["sensor_msgs.msg"] = None
"""
TRIALS = 200
TRY = """async ([file, runs]) => {
  const here = new URL('../../_static/workspace/', location);
  const { Machine } = await import(new URL('machine.js', here));
  const machine = new Machine(await (await fetch(new URL('manifest.json', here))).json());
  machine.serve({ hear() {}, ask() { throw new Error('silent'); } });
  const [hand] = machine.hands;
  const made = [];
  for (const [scenario, text] of runs) {
    const order = { file: `/home/reader/${file}`, others: [file], scenario };
    const [ended, recordings] = await hand.call('trial', order, { files: { [file]: text } });
    made.push(ended.lead ? null : recordings[`${scenario}.pickle`]);
  }
  return [made[0], made.at(-1)].map((bytes) => Array.from(bytes));
}"""
DIGESTS = """
import json, pickle, sys
sys.path[:0] = sys.argv[1:]
import msgspec
msgspec.msgpack.encode = lambda each: repr(each).encode()  # equal values, equal bytes
print(*(pickle.loads(bytes(each))[0].digest() for each in json.load(sys.stdin)))
"""
DRIVE_ON = "import time\n\nwhile True:\n    pass\n"

pytestmark = pytest.mark.skipif(
    not MADE.is_file(), reason="the site has no workspace here: run `make workspace`"
)


@pytest.fixture
def open_workspace(open_served: Any) -> Any:
    """Open an exercise's workspace."""

    def open_(hash_: str = "#workspace", slug: str = SLUG, script: str = "", **options: Any) -> Any:
        page = open_served(f"exercises/{slug}/README.html{hash_}", script, **options)
        page.locator(".cm-content:visible").wait_for()
        return page

    return open_


def check(page: Any, *texts: str) -> str:
    settle(page)
    for number, text in enumerate(texts):
        if texts[1:]:
            page.locator(".ws-files button").nth(number).click()
        type_in(page, text)
    page.keyboard.press("Control+Shift+Enter")
    return settle(page)


@pytest.mark.parametrize("slug", [exercise.slug for exercise in all_exercises()])
def test_nodes_that_are_typed_in_get_the_verdicts_of_course_grade(
    open_workspace: Any, forkserver: ForkServer, tmp_path: Path, slug: str
) -> None:
    exercise = find_exercise(slug)
    first, *others = exercise.files
    checks = plan(exercise)["checks"]
    here = [check["id"] for check in checks if check["scenarios"]]
    only = here if len(here) < len(checks) else ()  # or its trials come in another order
    page = open_workspace(slug=slug)
    different = {}
    first_three = [mutant.name for mutant in mutants(exercise)[:3]]
    for mutant in (None, *TYPED.get(slug, first_three)):
        files = submission_of(exercise, find_mutant(exercise, mutant) if mutant else None)
        for name, text in files.items():
            (tmp_path / name).write_text(text, "utf-8")
        submission = find_submission(tmp_path, first, others)
        graded = grade_submission(exercise, submission, forkserver, file=first, only=only)
        assert "points" in check(page, *files.values())
        found = dict(page.locator(".ws-list li").evaluate_all(SAID))
        said = page.locator(".ws-cause").all_inner_texts()
        wanted = {c.id: [c.outcome, c.message] for c in graded.checks}
        for name in set(here) - set(MEASURED):
            if found[name] != wanted[name]:
                different[mutant, name] = (found[name], wanted[name])
        if bool(said) != bool(graded.cause) or (said and graded.cause.text not in said[0]):
            different[mutant, "cause"] = (said, graded.cause)
    assert different == {}


def test_the_first_failure_is_shown_where_it_happens(open_workspace: Any) -> None:
    page = open_workspace()
    assert RIGHT.count("twist.linear.x = speed") == 1
    check(page, RIGHT.replace("twist.linear.x = speed", "twist.linear.x = speed + 0.3"))
    button = page.locator("li[data-outcome=fail] button").first
    moment = button.inner_text().removeprefix("Show ").removesuffix(" s")
    replay = page.frame_locator(".ws-replay iframe")  # it leads up to the moment, and stops there
    replay.locator(".clock", has_text=f"{moment} /").wait_for()
    marked = page.locator(".cm-lintRange-error").inner_text()
    assert marked.strip().startswith("self.drive(")
    page.locator("li[data-outcome=fail] button", has_text="A hint").first.click()
    page.locator(".ws-hints details p").first.wait_for()


@pytest.mark.parametrize("width", [1280, 1000, 390])
def test_what_the_node_logs_and_prints_leads_to_its_moment(
    open_workspace: Any, axe: Callable[[Any], list[str]], width: int
) -> None:
    page = open_workspace(viewport={"width": width, "height": 800})
    settle(page)
    said = 'twist.linear.x = speed\n        print("it is", speed)'
    type_in(page, RIGHT.replace("twist.linear.x = speed", said))
    page.keyboard.press("Control+Enter")
    settle(page)
    replay = page.frame_locator(".ws-replay iframe")
    line = replay.locator(".log-line", has_text="it is").nth(10)
    line.wait_for()
    if width == 1280:  # beside the map, in one view with the timeline
        frame, *parts = (
            place.bounding_box()
            for place in (
                page.locator(".ws-replay"),
                replay.locator(".log-list"),
                replay.locator(".timeline-track"),
                replay.locator(".plot"),
            )
        )
        assert all(p["y"] + p["height"] <= frame["y"] + frame["height"] for p in parts)
    stage, below = (replay.locator(part).bounding_box() for part in (".stage", ".readout"))
    assert stage["y"] + stage["height"] <= below["y"] + 1
    moment = line.locator(".log-time").inner_text()
    line.click()
    replay.locator(".clock", has_text=f"{moment} /").wait_for()
    assert axe(page) == []


def test_changes_are_those_since_the_last_version_that_passed(
    open_workspace: Any, axe: Callable[[Any], list[str]]
) -> None:
    page = open_workspace()
    changes = page.get_by_role("button", name="Changes")
    assert changes.is_disabled()
    assert check(page, RIGHT) == "100 of 100 points."
    changes.click()
    assert "This is what passed" in page.locator(".ws-score").inner_text()
    check(page, RIGHT.replace("twist.linear.x = speed", "twist.linear.x = speed + 0.3") + "# more")
    changes.click()
    changed = page.locator(".ws-changes [data-sign]:not([data-sign=' '])").all_inner_texts()
    assert [line.split(maxsplit=1) for line in changed] == [
        ["-", "twist.linear.x = speed\n"], ["+", "twist.linear.x = speed + 0.3\n"],
        ["-"], ["+", "# more\n"],
    ]  # fmt: skip
    assert axe(page) == []


def test_a_node_that_wrecks_python_leaves_nothing_for_the_next(open_workspace: Any) -> None:
    page = open_workspace()
    assert check(page, WRECKS).startswith("0 of 100")
    assert check(page, RIGHT) == "100 of 100 points."


def test_nobody_types_to_a_node(open_workspace: Any) -> None:
    page = open_workspace()
    assert check(page, "speed = float(input('How fast? '))\n").startswith("0 of 100")
    assert "Nobody types to a node here" in page.locator(".ws-cause").first.inner_text()


@pytest.mark.long
def test_two_hundred_trials_in_one_worker_leave_nothing_behind(
    open_workspace: Any, tmp_path: Path
) -> None:
    page = open_workspace()
    settle(page)
    exercise = find_exercise(SLUG)
    [file] = exercise.files
    scenarios = list(plan(exercise)["scenarios"])
    reference = (exercise.solutions / file).read_text("utf-8")
    runs = [[scenarios[i % len(scenarios)], reference] for i in range(TRIALS)]
    runs[TRIALS // 2][1] = WRECKS
    runs[-1] = runs[0]
    made = json.dumps(page.evaluate(TRY, [file, runs]))
    lay(tmp_path, page_packages())
    command = [sys.executable, "-c", DIGESTS, str(tmp_path / PAGE_PACKAGES), str(ROOT)]
    first, last = subprocess.check_output(command, input=made, text=True).split()
    assert first == last


def test_a_drive_slower_than_a_robots_is_called_that(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    slow = "sum(i * i for i in range(4_000_000))"
    type_in(page, RIGHT.replace("distance = front_distance(scan)", f"distance = {slow}"))
    page.keyboard.press("Control+Enter")
    page.locator(".ws-status", has_text="more slowly than a robot").wait_for(timeout=SLOW)
    page.get_by_role("button", name="Stop", exact=True).click()


def test_a_drive_tells_what_course_drive_tells(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    page.get_by_role("button", name="Drive").press("Enter")
    settle(page)
    assert page.evaluate("document.activeElement.textContent") == "Drive"  # no keyboard is lost
    assert "nothing was published on /cmd_vel" in page.get_by_label("The drive").inner_text()


def test_what_was_typed_survives_a_stop_and_a_reload(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    type_in(page, DRIVE_ON)
    page.keyboard.press("Control+Enter")
    page.get_by_role("button", name="Stop it").click(timeout=SLOW)
    assert settle(page) == "Stopped."
    type_in(page, "import rclpy\n")
    page.keyboard.press("Control+Enter")  # of the spare, or of another start
    assert "ended early" in settle(page)
    type_in(page, DRIVE_ON)
    page.reload()
    page.locator(".cm-content").wait_for()
    assert "while True" in typed(page)


def test_a_link_carries_the_code_and_puts_aside_what_was_there(open_workspace: Any) -> None:
    page = open_workspace(permissions=["clipboard-read", "clipboard-write"])
    type_in(page, "# über alles\n")
    page.get_by_role("button", name="Link").click()
    page.locator(".ws-status", has_text="Copied").wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    type_in(page, "# mine\n")
    page.goto(link)
    page.locator(".cm-line", has_text="über alles").wait_for()
    page.reload()
    page.locator(".cm-line", has_text="über alles").wait_for()
    assert "code=" not in page.url
    page.get_by_label("Earlier versions").select_option(index=1)
    assert "# mine" in typed(page)


@pytest.mark.parametrize(
    ("slug", "hash_", "script", "said"),
    [
        (SLUG, "#code=eJwDAAAA", "", "cut on its way"),
        (SLUG, f"#code={urlsafe_b64encode(BOMB).decode()}", "", "longer than any node"),
        (SLUG, "#workspace", "delete globalThis.WebAssembly", "needs WebAssembly"),
        (SLUG, "#workspace", NO_STORAGE, "keeps nothing"),
        ("slow_model", "#workspace", "delete WebAssembly.Suspending", "needs threads"),
    ],
)
def test_what_is_missing_is_said_in_a_sentence_and_one_can_type(
    open_workspace: Any, slug: str, hash_: str, script: str, said: str
) -> None:
    page = open_workspace(hash_, slug, script)
    page.locator(".ws-news", has_text=said).wait_for(timeout=SLOW)
    type_in(page, "# mine")
    assert typed(page).strip() == "# mine"


def test_without_javascript_the_page_says_so(open_served: Any) -> None:
    page = open_served(f"exercises/{SLUG}/README.html", java_script_enabled=False)
    said = page.locator(".workspace-block").inner_text()
    assert said == "The workspace is not running: it needs JavaScript."


def test_an_old_browser_has_a_plain_field_that_keeps_what_is_typed(open_served: Any) -> None:
    old = "delete globalThis.DecompressionStream"
    page = open_served(f"exercises/{SLUG}/README.html#workspace", old)
    page.locator(".ws-status", has_text="needs DecompressionStream").wait_for(timeout=SLOW)
    field = page.locator(".ws-code textarea")
    field.fill("# mine")
    page.reload()
    assert field.input_value() == "# mine"


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 390)])
def test_axe_has_nothing_against_a_failing_workspace(
    open_workspace: Any, axe: Callable[[Any], list[str]], scheme: str, width: int
) -> None:
    page = open_workspace(color_scheme=scheme, viewport={"width": width, "height": 800})
    check(page, "import nothing_of_that_name\n")
    assert axe(page) == []
    page.locator(".ws-tabs button").first.dispatch_event("click")  # on a phone
    page.get_by_role("button", name="Task").click()
    assert axe(page) == []


def test_the_editor_knows_messages_and_nodes(open_workspace: Any) -> None:
    page = open_workspace()
    type_in(page, "scan.")
    page.keyboard.type("range_m")
    page.locator(".cm-completionLabel", has_text="range_max").click()
    page.keyboard.type("\nself.create_subs")
    page.locator(".cm-completionLabel", has_text="create_subscription").click()
    assert typed(page).split() == ["scan.range_max", "self.create_subscription"]


def test_an_empty_editor_is_told_how_to_begin_again(open_workspace: Any) -> None:
    page = open_workspace(slug="model_server")
    settle(page)
    type_in(page, " \n")
    page.locator(".ws-files button").nth(1).click()
    for act in ("Drive", "Check"):
        page.get_by_role("button", name=act, exact=True).click()
        assert (
            page.locator(".ws-status")
            .inner_text()
            .startswith("detection_server.py is empty: Reset")
        )
    page.get_by_role("button", name="Reset").click()
    assert "Detection server" in typed(page)


def test_a_later_visit_needs_no_server(chromium: Any, site: Path, tmp_path: Path) -> None:
    context = chromium.new_context()
    page = context.new_page()
    with served(site, tmp_path) as address:
        page.goto(f"{address}/exercises/{SLUG}/README.html#workspace")
        assert settle(page) == "Ready."
        page.evaluate(KEPT)
    page.reload()
    page.locator(".cm-content").wait_for()
    assert settle(page) == "Ready."
    page.get_by_role("button", name="Drive").click()
    assert "Driven to the end" in settle(page)
    page.get_by_role("button", name="Race").click()
    assert settle(page) == "Race: 3 of 3 worlds finished."
    assert page.locator(".ws-race th", has_text="reference").count() == 3
    context.close()


def test_what_the_server_should_not_have_sent_is_not_kept(open_served: Any) -> None:
    page = open_served(f"exercises/{SLUG}/README.html")
    login = {"status": 200, "content_type": "text/html", "body": "<h1>Log in</h1>"}
    page.context.route("**/course.pack*", lambda route: route.fulfill(**login))
    page.get_by_role("button", name="Open the workspace").click()
    page.locator(".cm-content").wait_for()
    assert "course.pack: the server sends something else" in settle(page)
    page.context.unroute("**/course.pack*")
    page.reload()
    assert settle(page) == "Ready."


def test_code_of_a_link_cannot_reach_the_site(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    names = ("caches", "indexedDB", "fetch", "XMLHttpRequest", "WebSocket", "Worker", "navigator")
    script = " + ".join(f"typeof {name}" for name in names)
    hidden = "typeof WorkerGlobalScope.prototype.fetch"
    text = f"raise ValueError(run_js({script!r}) + ' ' + run_js({hidden!r}))"
    type_in(page, f"from pyodide.code import run_js\n\n{text}\n")
    page.keyboard.press("Control+Enter")
    assert f"ValueError: {'undefined' * len(names)} undefined" in settle(page)


def test_two_tabs_do_not_overwrite_each_other(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    type_in(page, "# mine\n")
    other, late = (page.context.new_page() for _ in range(2))
    late.goto(page.url.partition("#")[0])
    late.get_by_role("button", name="Open the workspace").wait_for()
    other.goto(page.url)
    other.locator(".ws-news", has_text="open in another tab").wait_for(timeout=SLOW)
    type_in(other, "# theirs\n")
    page.reload()
    page.locator(".cm-line", has_text="mine").wait_for()
    page.close()
    other.locator(".ws-status", has_text="The other tab is closed").wait_for(timeout=SLOW)
    other.reload()
    other.locator(".cm-line", has_text="theirs").wait_for()
    assert other.get_by_label("Earlier versions").locator("option").count() == 2
    other.close()
    late.get_by_role("button", name="Open the workspace").click()  # what it loaded is long gone
    late.locator(".cm-line", has_text="theirs").wait_for()


def test_a_python_that_a_node_broke_starts_anew(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    assert check(page, "import os\n\nos.abort()\n").startswith("Your node broke Python itself")
    assert check(page, "print('still here')\n").startswith("0 of 100")
    assert page.locator(".ws-stale").is_hidden()
    type_in(page, "# changed\n")
    assert page.locator(".ws-stale").is_visible()
    page.keyboard.press("Control+Enter")  # now the pane speaks of this text, and of no other
    page.get_by_label("The drive").wait_for(timeout=SLOW)
    assert page.locator(".ws-stale").is_hidden()
    assert page.locator("[data-outcome=fail]").count() == 0


def test_a_check_with_a_seed_is_of_other_worlds_and_one_can_be_kept(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    page.get_by_label("seed", exact=True).fill("7")
    narrow = find_mutant(find_exercise(SLUG), "narrow_cone").text
    assert check(page, narrow).endswith("of 100 points in the worlds of seed 7.")
    with page.expect_download() as download:
        page.get_by_role("button", name="Keep this world").first.click()
    name, _, failed = download.value.suggested_filename.removesuffix(".toml").partition("_seed7_")
    assert page.locator(f"[data-check={failed}][data-outcome=fail]").is_visible()
    kept, own = load_scenario(download.value.path()), load_scenario(name)
    seed = trial_seed(own, 7)
    assert kept.trial_seed == seed != own.seed
    assert Simulation(kept).scenario.bench == Simulation(own, seed).scenario.bench
    assert "avoid_field_turned" in page.locator(".ws-score").inner_text()
    page.get_by_label("seed", exact=True).fill("")
    score = check(page, narrow).partition(" points")[0]
    assert page.locator(".cm-activeLine .cm-lintRange-error").count() == 1
    versions = page.get_by_label("Earlier versions")
    assert f": {score}; seed 7: " in versions.inner_text()
    versions.press("ArrowDown")  # opens the list, and takes none
    assert page.locator(".ws-status").inner_text() == f"{score} points."
    page.keyboard.press("Escape")
    choose = page.get_by_label("Scenario", exact=True)
    choose.select_option(f"{name}_seed7_{failed}.toml")
    page.get_by_role("button", name="Drive", exact=True).click()
    settle(page)
    assert "Single scans: whether" in page.get_by_label("The drive").inner_text()


def test_what_is_typed_during_a_check_is_not_checked(open_workspace: Any) -> None:
    page = open_workspace()
    settle(page)
    type_in(page, RIGHT)
    page.keyboard.press("Control+Shift+Enter")
    page.locator("dialog.workspace[aria-busy=true]").wait_for()  # a run may be over in no time
    type_in(page, "# changed\n")
    assert settle(page) == "100 of 100 points."
    assert page.locator(".ws-stale").is_visible()
    type_in(page, "raise ValueError\n")
    page.keyboard.press("Control+Shift+Enter")
    page.locator("dialog.workspace[aria-busy=true]").wait_for()
    type_in(page, "\n# one\n# two")
    assert settle(page).startswith("0 of 100")
    assert page.locator(".cm-activeLine").inner_text() == "# two"  # the cursor stays


def test_several_files_are_kept_marked_and_reset_one_by_one(
    open_workspace: Any, axe: Callable[[Any], list[str]]
) -> None:
    page = open_workspace(slug="model_server", permissions=["clipboard-read", "clipboard-write"])
    exercise = find_exercise("model_server")
    server, client = [(exercise.solutions / name).read_text("utf-8") for name in exercise.files]
    broken = client.replace("self.beats += 1", "self.beats += 1 / 0")
    check(page, server, broken)
    shown = page.locator(".ws-files [aria-pressed=true]")
    assert shown.inner_text() == "detection_client.py"
    assert page.locator(".cm-lintRange-error:visible").inner_text() == "self.beats += 1 / 0"
    page.get_by_role("button", name="Reset").click()
    assert "never waits for it" in typed(page)
    assert page.locator(".cm-lintRange-error").count() == 0
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "detection_client.py"
    page.get_by_role("button", name="detection_server.py").click()
    type_in(page, "# mine\n")
    page.get_by_role("button", name="Link").click()
    page.locator(".ws-status", has_text="Copied").wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    type_in(page, "# another\n")
    page.goto(link)
    page.locator(".cm-line:visible", has_text="mine").wait_for()
    page.reload()
    page.locator(".cm-line:visible", has_text="mine").wait_for()
    page.get_by_role("button", name="detection_client.py").click()
    assert "never waits for it" in typed(page)
    page.get_by_label("Earlier versions").select_option(index=1)
    assert "never waits for it" in typed(page)
    page.get_by_role("button", name="detection_server.py").click()
    assert "# another" in typed(page)
    assert axe(page) == []


def test_a_program_that_ends_while_others_go_on_is_named_after_a_drive(open_workspace: Any) -> None:
    page = open_workspace(slug="three_nodes")
    exercise = find_exercise("three_nodes")
    *others, _guard = [(exercise.solutions / name).read_text("utf-8") for name in exercise.files]
    settle(page)
    for number, text in enumerate([*others, "print(\n"]):
        page.locator(".ws-files button").nth(number).click()
        type_in(page, text)
    page.keyboard.press("Control+Enter")
    said = settle(page)
    assert said.startswith("Driven to the end of shuttle_")
    for words in ("guard.py", "SyntaxError in line 1", "the other programs went on"):
        assert words in said
