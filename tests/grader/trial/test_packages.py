"""What lies beside a node comes along, and a colcon package runs as on a robot."""

from pathlib import Path

import msgspec
import pytest
from laid_packages import INNER, LAUNCH, MINE, NODE, SETUP, XML, lay
from node_runs import short

from grader.course import beside
from grader.course.submission import Program, Submission, find_submission
from grader.errors import InputError
from grader.recording import Recording
from grader.trial.kept import KeptRecordings
from grader.trial.packages import unpacked
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import NodeSpec, ProgramSpec


def drive(submission: Submission, forkserver: ForkServer, **options: object) -> Recording:
    return run_trial(unpacked(submission, forkserver), short(0.3), forkserver, **options)


def said(recording: Recording) -> list[str]:
    return [line.text for line in recording.log] or [recording.outcome.text]


@pytest.mark.parametrize(
    ("files", "arguments", "expected"),
    [
        ({"node.py": "from helper import A\nprint(A)", "helper.py": "A = 7"}, (), "7"),
        ({"node.py": "import kit.a\nprint(kit.a.B)", "kit/a.py": "B = 8"}, (), "8"),
        ({"node.py": "print(open('m/x.txt').read())", "m/x.txt": "9"}, (), "9"),
        (
            {"node.py": "import os\nprint(os.path.exists(os.path.expanduser('~/x.txt')))",
             "x.txt": "9"},
            (),
            "False",
        ),
        (
            {"node.py": "import sys\nprint(open(sys.argv[1]).read())", "own.onnx": "weights"},
            ("own.onnx",),
            "weights",
        ),
        ({"node.py": "from .helper import A", "helper.py": "A = 7"}, (), "leave the dot out"),
        ({"node.py": "from kit import A", "kit/a.py": "A = 7"}, (), "add that file"),
        ({"node.py": "import helper", "helper.py": "1 / 0"}, (), "(helper.py, line 1, in"),
    ],
)  # fmt: skip
def test_a_file_finds_what_lies_beside_it(
    files: dict[str, str],
    arguments: tuple[str, ...],
    expected: str,
    forkserver: ForkServer,
    tmp_path: Path,
) -> None:
    recording = drive(
        find_submission(lay(tmp_path, files) / "node.py"), forkserver, arguments=arguments
    )
    assert expected in [*said(recording), recording.outcome.text][0] + recording.outcome.text


def test_two_nodes_of_a_package_as_its_launch_file_says(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    inside = {"src/mine/" + name: text for name, text in MINE.items()}
    inside |= {"src/mine/launch/all.launch.py": LAUNCH, "src/mine/launch/inner.launch.py": INNER}
    submission = unpacked(find_submission(lay(tmp_path, inside)), forkserver)

    assert not submission.problem
    assert "rviz2 of the package rviz2 is not started here" in submission.left
    # a module of both: on a robot each process has its own
    assert said(drive(submission, forkserver)) == ["mine.one first shared 1", "mine.two node n7 1"]


def test_a_setup_reads_its_manual_and_a_namespace_needs_no_slash(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    launch = INNER.replace('t("word")', 't("word", default_value="so")').replace(
        "parameters=", 'namespace=LaunchConfiguration("word"), parameters='
    )
    setup = SETUP.replace('name="mine"', 'name="mine", long_description=open("README.md").read()')
    lay(tmp_path, {**MINE, "setup.py": setup, "README.md": "mine", "a.launch.py": launch})
    lay(tmp_path, {"mine/two.py": NODE.replace("get_name", "get_fully_qualified_name")})
    submission = unpacked(find_submission(tmp_path), forkserver)
    assert said(drive(submission, forkserver)) == ["mine.two /so/node nso 1"]
    assert submission.left[-1].startswith("a.launch.py by `data_files`")


GROUPED = """
    from launch import LaunchDescription
    from launch.actions import (DeclareLaunchArgument, GroupAction, IncludeLaunchDescription,
                                LogInfo, OpaqueFunction, Shutdown)
    from launch.conditions import IfCondition, UnlessCondition
    from launch.launch_description_sources import PythonLaunchDescriptionSource
    from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
    from launch_ros.actions import Node, PushRosNamespace, SetParameter
    from launch_ros.parameter_descriptions import ParameterFile, ParameterValue

    def generate_launch_description():
        sim, here = LaunchConfiguration("sim"), [ThisLaunchFileDir(), "/inner.launch.py"]
        return LaunchDescription([
            DeclareLaunchArgument("sim", default_value="True"), LogInfo(msg=["sim ", sim]),
            GroupAction([
                PushRosNamespace("bot"), SetParameter(name="word", value="w7"),
                Node(package="mine", executable="one", condition=IfCondition(sim))]),
            Node(package="mine", executable="one", condition=UnlessCondition(sim)),
            GroupAction([
                IncludeLaunchDescription(PythonLaunchDescriptionSource(here),
                                         launch_arguments={"word": "5"}.items())]),
            Node(package="mine", executable="one", name="first", namespace="", arguments=["-x"],
                 on_exit=Shutdown(),
                 parameters=[ParameterFile("config/p.yaml", allow_substs=True),
                             {"word": ParameterValue(LaunchConfiguration("word", default="3"),
                                                     value_type=str)}])])
    """


def test_actions_of_launch_files_mean_what_they_mean_to_ros2_launch(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    node = NODE.replace("get_name", "get_fully_qualified_name").replace(
        "print(__name__", "import sys; print(sys.argv[1:2] == ['-x']"
    )
    files = {**MINE, "mine/one.py": node, "launch/inner.launch.py": INNER}
    files["launch_params_1.yaml/theirs"] = ""
    lay(
        tmp_path,
        {
            **files,
            "launch/all.launch.py": GROUPED,
            "config/p.yaml": """
        /first: {ros__parameters: {word: file}}""",
        },
    )
    submission = unpacked(find_submission(tmp_path), forkserver)
    assert said(drive(submission, forkserver)) == [
        "False /bot/node w7 1", "mine.two node n5 1", "True /first 3 1"
    ]  # fmt: skip
    assert [program.needed for program in submission.started()] == [False, False, True]


CMAKE = """
    project(bringup)  # install(FILES none DESTINATION share)
    install(DIRECTORY launch config/ DESTINATION share/${PROJECT_NAME})
    install(PROGRAMS tools/extra.py DESTINATION lib/${PROJECT_NAME})
    """
WORKSPACE = {
    **{f"src/mine/{name}": text for name, text in MINE.items()},
    "src/bringup/package.xml": "<package><name>bringup</name></package>",
    "src/bringup/CMakeLists.txt": CMAKE,
    "src/bringup/config/q.yaml": "/**: {ros__parameters: {word: brought}}",
    "src/bringup/tools/extra.py": "print('extra')",
}
BRINGUP = """
    from ament_index_python.packages import get_package_share_directory
    from launch import LaunchDescription
    from launch.actions import IncludeLaunchDescription
    from launch_ros.actions import Node

    def generate_launch_description():
        file = get_package_share_directory("bringup") + "/q.yaml"
        return LaunchDescription([
            IncludeLaunchDescription(get_package_share_directory("tb3") + "/launch/w.launch.py"),
            Node(package="bringup", executable="extra.py"),
            Node(package="cartographer_ros", executable="cartographer"),
            Node(package="mine", executable="two", parameters=[file])])
    """


@pytest.mark.parametrize(
    ("launch", "given"),
    [
        ("src/bringup/launch/a.launch.py", "."),
        ("src/bringup/launch/a.launch.py", "src/bringup/launch/a.launch.py"),
        ("src/a.launch.py", "src/a.launch.py"),
        ("src/bringup/launch/a.launch.py", "src/mine/../bringup/launch/a.launch.py"),
    ],
)
def test_a_launch_file_starts_nodes_of_other_packages(
    launch: str, given: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    no = {
        "src/no/package.xml": "",
        "src/no/setup.py": "raise SystemExit",
        "src/no/AMENT_IGNORE": "",
    }
    lay(tmp_path, {**WORKSPACE, launch: BRINGUP, **no})
    submission = unpacked(find_submission(tmp_path / given), forkserver)
    assert said(drive(submission, forkserver)) == ["extra", "mine.two node brought 1"]
    assert submission.left[0] == "w.launch.py of the package tb3 is not started here"
    assert submission.left[1].startswith("cartographer of the package cartographer_ros")


@pytest.mark.parametrize("given", ["bringup", "bringup/extra.py", "mine/scripts/run.py"])
def test_a_program_that_cmake_installs_or_that_imports_its_package_runs(
    given: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    both = {"src/bringup/tools/extra.py": "import bringup.part\nprint(bringup.part.A)"}
    both |= {"src/bringup/bringup/part.py": "A = 7", "src/bringup/bringup/__init__.py": ""}
    both["src/mine/scripts/two.py"] = ""
    both["src/bringup/CMakeLists.txt"] = f"{CMAKE}\nament_python_install_package(${{PROJECT_NAME}})"
    both["src/mine/scripts/run.py"] = "import mine.common, two\nprint(mine.common.counted() + 6)"
    lay(tmp_path, WORKSPACE | both)
    submission = unpacked(find_submission(tmp_path / "src" / given), forkserver)
    assert said(drive(submission, forkserver)) == ["7"]


def test_a_workspace_is_asked_for_what_to_start(forkserver: ForkServer, tmp_path: Path) -> None:
    launches = {f"src/bringup/launch/{name}.launch.py": BRINGUP for name in ("a", "b")}
    submission = unpacked(find_submission(lay(tmp_path, WORKSPACE | launches)), forkserver)
    assert "NAME (bringup extra.py, mine one, mine two)" in submission.problem
    assert all(name in submission.problem for name in launches)


def test_of_two_packages_with_the_exercises_file_one_is_named(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    again = {f"src/again/{name}": text.replace("mine", "again") for name, text in MINE.items()}
    again |= {f"src/again/again/{name}.py": NODE for name in ("__init__", "two")}
    submission = find_submission(lay(tmp_path, WORKSPACE | again), "two.py")
    assert "again two, " in unpacked(submission, forkserver).problem
    lay(tmp_path, {"src/again/package.xml": XML})
    assert "two packages are called mine" in unpacked(submission, forkserver).problem


def test_a_launch_file_of_no_package_is_refused(tmp_path: Path) -> None:
    lay(
        tmp_path, {"a.launch.py": BRINGUP, "node.py": NODE, **WORKSPACE, "src/b.launch.py": BRINGUP}
    )
    for given, expected in (("a.launch.py", "two.py"), ("src/b.launch.py", "two.py")):
        with pytest.raises(InputError, match="expected a launch file beside its programs"):
            find_submission(tmp_path / given, expected)
    for file in ("mine/setup.py", "bringup/CMakeLists.txt"):
        (tmp_path / "src" / file).unlink()
    with pytest.raises(InputError, match="expected a launch file beside its programs"):
        find_submission(tmp_path / "src" / "b.launch.py")


def test_a_launch_file_beside_its_programs(tmp_path: Path, forkserver: ForkServer) -> None:
    launch = INNER.replace('t("word")', 't("word", default_value="so")')
    launch = launch.replace('package="mine"', 'package="course_exercises"')
    lay(tmp_path, {"a.launch.py": launch, "two.py": NODE, "one.py": NODE})
    submission = unpacked(find_submission(tmp_path / "a.launch.py"), forkserver)
    assert not submission.problem
    (program,) = submission.started()
    assert (program.file, program.entry) == ("two.py", "")
    assert program.arguments
    assert submission.started("two.py") == (Program("two.py"),)  # alone, it is not launched


def test_a_package_with_too_many_files_stays_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(beside, "MAX_FILES", 12)
    many = {f"src/aaa/aaa/m{i}.py": "" for i in range(12)}
    lay(tmp_path, {**WORKSPACE, **many, "src/aaa/package.xml": XML, "src/aaa/setup.py": ""})
    lay(tmp_path, {"src/bringup/launch/a.launch.py": BRINGUP})
    found = find_submission(tmp_path / "src/bringup/launch/a.launch.py")
    assert found.package is not None
    assert found.package.folders[0] == "bringup"
    assert "aaa" not in found.package.folders
    assert any("12 files" in left for left in found.left)


@pytest.mark.parametrize("given", ["", "mine/two.py", "two"])
def test_without_a_launch_file_the_program_that_is_meant(
    given: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    submission = find_submission(lay(tmp_path, MINE) / given, "two.py")
    assert said(drive(submission, forkserver)) == ["mine.two node none 1"]
    assert submission.path == tmp_path / "mine" / "two.py"


def test_an_entry_point_may_be_called_as_its_package(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    lay(tmp_path, {**MINE, "setup.py": SETUP.replace("two =", "mine =")})
    assert said(drive(find_submission(tmp_path / "mine"), forkserver)) == ["mine.two node none 1"]


@pytest.mark.parametrize("out", [(), ("mine.sub",)])
def test_a_file_without_an_entry_point_runs_as_python3_runs_it(
    out: tuple[str, ...], forkserver: ForkServer, tmp_path: Path
) -> None:
    setup = SETUP.replace('["test"]', f"{list(out)}")
    file = "from mine.common import counted\nprint(__name__, counted())\n"
    inside = {**MINE, "setup.py": setup, "mine/sub/__init__.py": "", "mine/sub/new.py": file}
    lay(tmp_path, inside)
    assert said(drive(find_submission(tmp_path / "mine/sub/new.py"), forkserver)) == ["__main__ 1"]


def test_launch_files_that_are_not_in_python_are_left_to_a_person(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    """Where the program is known without, the report only says that they were not read."""
    lay(tmp_path, {**MINE, "launch/all.launch.xml": "<launch/>"})
    one, several = (
        unpacked(find_submission(tmp_path, name), forkserver) for name in ("two.py", "robot.py")
    )
    said_of_it = "launch/all.launch.xml: of launch files only those in Python are read here"
    assert one.package is not None and not one.package.problem
    assert said_of_it in one.left
    assert several.package is not None and several.package.held
    assert several.package.problem == said_of_it
    lay(tmp_path, {"launch/all.launch.xml": '<launch><remap from="a" to="b"/></launch>'})
    one = unpacked(find_submission(tmp_path, "two.py"), forkserver)
    assert one.package is not None and one.package.held  # it may be right only with what that says
    with pytest.raises(InputError, match="xml: of launch files only those in Python are read"):
        find_submission(tmp_path / "launch" / "all.launch.xml")


@pytest.mark.parametrize(("main", "refused"), [("robot_launch.py", True), ("two.py", False)])
def test_a_launch_file_that_is_not_installed_is_none_where_it_is_the_task(
    main: str, refused: bool, forkserver: ForkServer, tmp_path: Path
) -> None:
    launch = INNER.replace('t("word")', 't("word", default_value="so")')
    lay(tmp_path, {**MINE, "all.launch.py": launch})
    submission = unpacked(find_submission(tmp_path, main), forkserver)
    assert submission.package is not None
    assert ("does not find all.launch.py" in submission.package.problem) == refused


def test_a_scenario_names_a_program_of_a_package(forkserver: ForkServer, tmp_path: Path) -> None:
    lay(tmp_path, MINE)
    submission = unpacked(find_submission(tmp_path / "mine" / "one.py"), forkserver)
    scenario = msgspec.structs.replace(short(0.3), program=(ProgramSpec(file="two.py"),))
    assert said(run_trial(submission, scenario, forkserver)) == ["mine.two node none 1"]


CONFIGURED = {
    "setup.cfg": """
        [options]
        packages = find:
        [options.entry_points]
        console_scripts =
            one = mine.one:main
        """,
    "pyproject.toml": '[project.scripts]\none = "mine.one:main"\n',
}


@pytest.mark.parametrize("name", CONFIGURED)
def test_entry_points_of_other_files(name: str, forkserver: ForkServer, tmp_path: Path) -> None:
    files = {**MINE, name: CONFIGURED[name]}
    del files["setup.py"]
    assert said(drive(find_submission(lay(tmp_path, files)), forkserver)) == [
        "mine.one node none 1"
    ]


BROKEN = {
    "not installed": ({"mine/one.py": "import mine.sub.x", "mine/sub/x.py": ""}, "mine.sub"),
    "not there": ({"mine/one.py": "import nothing_such"}, "No module named 'nothing_such'"),
    "no entry": ({"setup.py": "import setuptools\nsetuptools.setup()"}, "has no entry point"),
    "no such data": ({"setup.py": SETUP.replace('glob("config/*.yaml")', '["c.yaml"]')}, "c.yaml"),
    "raises": ({"setup.py": "import os\n1 / 0"}, "setup.py, line 2: ZeroDivisionError"),
    "of ROS 1": ({"setup.py": "import catkin_pkg"}, "belongs to ROS 1"),
    "no setup": ({"setup.py": "pass"}, "does not call setup"),
    "no module": (
        {"setup.py": "import setuptools\nsetuptools.setup(packages=['mine'], entry_points="
                     "'[console_scripts]\\none=mine.gone:main')"},
        "mine.gone:main leads to no module that the package installs: there is no mine/gone.py",
    ),
    "no init": (
        {"setup.py": "import setuptools\nsetuptools.setup(packages=setuptools.find_packages(), "
                     "entry_points='[console_scripts]\\none=bare.one:main')", "bare/one.py": ""},
        "bare has no __init__.py",
    ),
    "left out": (
        {"setup.py": "import setuptools\nsetuptools.setup(packages=['mine'], entry_points="
                     "'[console_scripts]\\none=kit.one:main')",
         "kit/one.py": "", "kit/__init__.py": ""},
        "`packages` leave it out",
    ),
    "no list": (
        {"a.launch.py": INNER.replace("parameters=[{", "parameters={").replace("}]", "}")},
        "Node(parameters=…) takes a list",
    ),
    "no file": (
        {"a.launch.py": INNER.replace('t("word")', 't("word", default_value="")').replace(
            "parameters=[", "parameters=['share/mine/c.yaml', ")},
        "`data_files` in setup.py has to install",
    ),
    "which": ({}, "an entry point as PACKAGE_FOLDER/NAME (one, two)"),
    "which, and one is stale": (
        {"setup.py": SETUP.replace("mine.two", "mine.gone")},
        "an entry point as PACKAGE_FOLDER/NAME (one, two)",
    ),
    "unknown": (
        {"a.launch.py": "from launch.actions import ExecuteProcess\nExecuteProcess(cmd=['ls'])"},
        "launch.actions.ExecuteProcess is not known here",
    ),
    "condition": (
        {"a.launch.py": INNER.replace('package="mine"', 'package="mine", condition=1')},
        "condition=… takes IfCondition(…)",
    ),
    "no default": ({"a.launch.py": INNER}, "'word' needs a default"),
    "other package": (
        {"a.launch.py": LAUNCH.replace('Share("mine")', 'Share("nav2_bringup")'),
         "launch/inner.launch.py": INNER},
        "with its package.xml; its programs start alone as PACKAGE_FOLDER/NAME (one, two)",
    ),
    "no program": (
        {"a.launch.py": INNER.replace('"two"', '"three"').replace(
            't("word")', 't("word", default_value="")')},
        "a.launch.py starts three, but",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_with_a_package_is_one_line(
    name: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    files, expected = BROKEN[name]
    submission = find_submission(lay(tmp_path, {**MINE, **files}))
    if name.startswith("not "):
        submission = find_submission(tmp_path / "mine" / "one.py")
    outcome = drive(submission, forkserver).outcome
    assert not outcome.completed
    assert expected in outcome.text
    assert "beside the node" not in outcome.text
    assert "\n" not in outcome.text


@pytest.mark.parametrize("name", ["m.pkl", "m.pkl/below"])
def test_a_models_name_in_a_scenario_is_the_scenarios(
    name: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    """Where a scenario says that there is no model, the student's own does not take its place."""
    files = {"node.py": "import os\nprint(*map(os.path.exists, ['m.pkl', 'n.pkl']))"}
    submission = find_submission(
        lay(tmp_path, {**files, name: "mine", "n.pkl": "mine"}) / "node.py"
    )
    node = NodeSpec(parameters={"model_path": "m.pkl"})
    scenario = msgspec.structs.replace(short(0.3), node=node)
    assert said(run_trial(submission, scenario, forkserver)) == ["False True"]


def test_a_module_is_a_part_of_what_is_recorded(forkserver: ForkServer, tmp_path: Path) -> None:
    lay(tmp_path / "a", {"node.py": "import helper", "helper.py": "A = 7"})
    kept = KeptRecordings(tmp_path / "kept", "engine")
    node, scenario = tmp_path / "a" / "node.py", short(0.3)
    kept.put(find_submission(node), run_trial(find_submission(node), scenario, forkserver), {})

    seed = 1 if scenario.seed is None else scenario.seed
    assert kept.get(find_submission(node), scenario, seed, {})
    (tmp_path / "a" / "helper.py").write_text("A = 8")
    assert not kept.get(find_submission(node), scenario, seed, {})
