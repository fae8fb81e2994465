"""Build the notebooks for the browser, with JupyterLite and the pages' runtime: `make lite`.

`python -m workspace.lite OUT CACHE WORKSPACE` writes OUT, which `make site` takes along; WORKSPACE
is what `make workspace` has made. Pyodide comes from npm, by package-lock.json; what else of its
release a kernel needs, as numpy in workspace/build.py.
"""

import hashlib
import io
import json
import re
import shutil
import sys
import tempfile
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

from grader.authoring.handouts import notebooks, without
from grader.course.exercises import ROOT
from grader.course.installed import COURSE
from grader.errors import GraderError, InputError
from workspace.build import COURSE as OF_PAGES
from workspace.build import EPOCH, FILES, npm, pack, released, run

HERE = Path(__file__).resolve().parent
CORE = ("pyodide.js", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip")
OF_KERNELS = ("ipython", "jedi", "matplotlib", "micropip", "numpy", "sqlite3", "ssl")
FROM_INDEX = ("comm",)  # what Pyodide's release lacks
MODULE = "rclpy_agents_course"
KERNEL = f"{sys.prefix}/share/jupyter/labextensions/@jupyterlite/pyodide-kernel-extension"
# What a kernel needs of the course, and a page doesn't
MORE = re.compile(r"grader/(?!authoring|classroom|exercises|host|lms|testing)")


def main(arguments: list[str]) -> int:
    """Build the folder OUT, all of it or nothing."""
    if len(arguments) != 3:
        raise InputError("expected what to make, a folder for downloads, and the workspace")
    out, cache, workspace = (Path(argument).resolve() for argument in arguments)
    plan = json.loads((workspace / "plan.json").read_text("utf-8"))
    modules = npm(cache)
    with tempfile.TemporaryDirectory(dir=cache) as name:
        work = Path(name)
        _lite(work, plan["exercises"])
        _pyodide(work / "out" / "static" / "pyodide", cache, modules)
        _pack_notebook(work)
        _own_scripts(work / "out")
        shutil.rmtree(out, ignore_errors=True)
        shutil.move(work / "out", out)
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    print(f"{size:>12,}  in all, in {out}")
    return 0


def _lite(work: Path, plans: dict[str, Any]) -> None:
    """Let JupyterLite build its own part, with the notebooks of what a page judges as a whole."""
    left_out = {
        slug for slug, plan in plans.items()
        if not all(check["scenarios"] for check in plan["checks"])
    }  # fmt: skip
    (work / "contents").mkdir()
    for path, content in without(notebooks(work), left_out).items():
        (work / "contents" / Path(path).name).write_bytes(content)
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", "pypi"]
    run([*pip, *(f"{name}=={metadata.version(name)}" for name in FROM_INDEX)], work)
    settings = {
        "pyodideUrl": "./static/pyodide/pyodide.js",
        "disablePyPIFallback": True,
        "loadPyodideOptions": {"packages": [COURSE, "matplotlib"]},
    }
    config = {
        "appName": "Bridging Python agents with rclpy",
        "exposeAppInBrowser": True,  # to extensions and tests: `jupyterapp`
        "litePluginSettings": {"@jupyterlite/pyodide-kernel-extension:kernel": settings},
    }
    whole = {"jupyter-lite-schema-version": 0, "jupyter-config-data": config}
    (work / "jupyter-lite.json").write_text(json.dumps(whole), "utf-8")
    # JupyterLab's other extensions, which may be of another version, stay out
    building = {"ignore_sys_prefix": ["federated_extensions"], "federated_extensions": [KERNEL]}
    (work / "jupyter_lite_config.json").write_text(json.dumps({"LiteBuildConfig": building}))
    run([sys.executable, "-m", "jupyterlite_core", "build", "--contents", "contents",
          "--output-dir", "out", "--apps", "lab", "--apps", "notebooks", "--no-sourcemaps"],
         work)  # fmt: skip


def _pyodide(out: Path, cache: Path, modules: Path) -> None:
    """Lay Pyodide there, with the packages of its release that a kernel needs, and the course."""
    out.mkdir(parents=True)
    for name in CORE:
        shutil.copyfile(modules / "pyodide" / name, out / name)
    needed = released(OF_KERNELS, cache, modules)
    for about in needed.values():
        shutil.copyfile(cache / "pyodide" / about["file_name"], out / about["file_name"])
    wheel = f"{MODULE}-{metadata.version(COURSE)}-py3-none-any.whl"
    content = _wheel()
    (out / wheel).write_bytes(content)
    needed[COURSE] = {
        "name": COURSE,
        "version": metadata.version(COURSE),
        "file_name": wheel,
        "sha256": hashlib.sha256(content).hexdigest(),
        "install_dir": "site",
        "package_type": "package",
        "imports": [MODULE],
        "depends": [],
    }
    lock = json.loads((modules / "pyodide" / "pyodide-lock.json").read_text("utf-8"))
    (out / "pyodide-lock.json").write_text(json.dumps({**lock, "packages": needed}), "utf-8")


def _wheel() -> bytes:
    """Return a wheel with the module that lays the course into a kernel."""
    version = metadata.version(COURSE)
    about = f"Metadata-Version: 2.1\nName: {COURSE}\nVersion: {version}\n"
    files = {
        f"{MODULE}.py": (HERE / "kernel" / f"{MODULE}.py").read_text("utf-8"),
        f"{MODULE}-{version}.dist-info/METADATA": about,
    }
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name, EPOCH), text)
    return content.getvalue()


def _pack_notebook(work: Path) -> None:
    for path in (ROOT / "grader").rglob("*"):
        name = path.relative_to(ROOT).as_posix()
        if path.is_file() and FILES.search(name) and MORE.match(name) and not OF_PAGES.match(name):
            (work / "room" / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, work / "room" / name)
    pack(work / "out" / "static" / "notebook.pack", work / "room")


def _own_scripts(out: Path) -> None:
    """Say how far a kernel's start is, and keep what it loads for a visit without a network."""
    pyodide = out / "static" / "pyodide"
    sizes = {f"static/pyodide/{path.name}": path.stat().st_size for path in pyodide.iterdir()}
    loading, offline = ((HERE / "kernel" / name).read_text("utf-8")
                        for name in ("loading.js", "offline.js"))  # fmt: skip
    (out / "loading.js").write_text(loading.replace("SIZES = {}", f"SIZES = {json.dumps(sizes)}"))
    worker = out / "service-worker.js"
    worker.write_text(offline + worker.read_text("utf-8"))
    for app in ("lab", "notebooks"):
        page = out / app / "index.html"
        before, end, after = page.read_text("utf-8").rpartition("</body>")
        script = '<script type="module" src="../loading.js"></script>'
        page.write_text(f"{before}{script}{end}{after}", "utf-8")


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (GraderError, InputError) as error:
        sys.exit(f"lite: {error}")
