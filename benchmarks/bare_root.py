"""Run what other people's containers would run, in a bare Debian made here: no Docker is needed.

    sudo .venv/bin/python benchmarks/bare_root.py gradescope   # setup.sh, run_autograder
    sudo .venv/bin/python benchmarks/bare_root.py container    # Dockerfile, devcontainer.json

It needs root, debootstrap, mount namespaces, and a mirror of Debian and an index of packages that
can be reached. `FROM` is not followed: the root is Debian bookworm with its own Python. What stands
between a command and this machine is a chroot with mounts and processes of its own, so run only
what you know here.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COURSE = [sys.executable, "-m", "grader.cli"]
PATHS = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
CERTIFICATES = "/etc/ssl/certs/ca-certificates.crt"
KEPT = "etc/bare-root.crt"  # the same in the root, where no package writes it anew
ENTER = """\
set -e
for each in "$@"; do [ "$each" = -- ] && break; mkdir -p "$0$each"; mount --bind "$each" "$0$each"
shift; done; shift
mount -t proc proc "$0/proc"; mount --rbind /sys "$0/sys"; mount --bind /dev "$0/dev"
exec chroot "$0" "$@"
"""
# What Docker leaves to root in a container
CAPABILITIES = (
    "-all,+chown,+dac_override,+fowner,+fsetid,+kill,+setgid,+setuid,+setpcap,"
    "+net_bind_service,+net_raw,+sys_chroot,+mknod,+audit_write,+setfcap"
)


class Bare:
    """A root file system with nothing of the course in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        _run(["debootstrap", "--variant=minbase", "bookworm", str(folder)])
        config = subprocess.run(
            [sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True,
            check=True,
        ).stdout  # fmt: skip
        lines = [line.partition("=") for line in config.splitlines()]
        values = {key.partition(".")[2]: value.strip("'") for key, _, value in lines}
        self.folders = sorted({path for value in values.values() for path in _folders(value)})
        self._copy("/etc/resolv.conf")
        shutil.copyfile(CERTIFICATES, folder / KEPT)
        values["cert"] = f"/{KEPT}"
        pip = "\n".join(f"{key} = {value}" for key, value in values.items())
        (folder / "etc" / "pip.conf").write_text(f"[global]\n{pip}\n", "utf-8")

    def run(
        self,
        command: Sequence[str],
        *,
        environment: Mapping[str, str] | None = None,
        prefix: Sequence[str] = (),
    ) -> str:
        """Run a command in it; return what it said."""
        settings = {"PATH": PATHS, "HOME": "/root", **(environment or {})}
        inside = ["env", "-i", *(f"{key}={value}" for key, value in settings.items())]
        return _run(
            ["unshare", "--mount", "--pid", "--fork", "sh", "-c", ENTER, str(self.folder),
             *self.folders, "--", *inside, *prefix, *command]
        )  # fmt: skip

    def _copy(self, path: str) -> None:
        target = self.folder / path.lstrip("/")
        target.parent.mkdir(parents=True, exist_ok=True)
        target.unlink(missing_ok=True)
        shutil.copyfile(path, target)


def main() -> int:
    """Make the root, run the steps, say what they gave and how long they took."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=["gradescope", "container"])
    parser.add_argument("--folder", help="where the root is made; it stays there")
    what = parser.parse_args()
    if os.geteuid() or not shutil.which("debootstrap"):
        print("expected root and debootstrap", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="bare-root-", ignore_cleanup_errors=True) as name:
        bare = Bare(Path(what.folder or name) / "root")
        (gradescope if what.what == "gradescope" else container)(bare, Path(name))
    return 0


# --- Gradescope ------------------------------------------------------------------------------


def gradescope(bare: Bare, work: Path) -> None:
    """Build the image as Gradescope's documents say, and grade three submissions."""
    secret = work / "secret"
    secret.write_text(os.urandom(16).hex(), "utf-8")
    release = ["release", str(work / "upload"), "--gradescope", "--exercise", "1"]
    _run([*COURSE, *release, "--secret", str(secret)])
    place = bare.folder / "autograder"
    for name in ("source", "submission", "results"):
        (place / name).mkdir(parents=True)
    _run(["unzip", "-q", str(work / "upload" / "autograder.zip"), "-d", str(place / "source")])
    with zipfile.ZipFile(work / "upload" / "autograder.zip") as archive:
        print(f"autograder.zip: {len(archive.namelist())} files")
    shutil.copy(place / "source" / "run_autograder", place)
    start = time.monotonic()
    bare.run(["bash", "/autograder/source/setup.sh"])
    print(f"setup.sh: {time.monotonic() - start:.0f} s")
    file = "obstacle_avoidance_agent.py"
    solution = (ROOT / "solutions" / "obstacle_avoidance" / file).read_text("utf-8")
    wall = "for name in ('source/course.secret', 'results/results.json'):\n    open(name)\n"
    for what, files in {
        "the solution": {file: solution}, "under another name": {"Agent (1).py": solution},
        "one that looks for results": {file: f"import os\nos.chdir('/autograder')\n{wall}"},
    }.items():  # fmt: skip
        for text in (place / "submission").iterdir():
            text.unlink()
        for name, content in files.items():
            (place / "submission" / name).write_text(content, "utf-8")
        start = time.monotonic()
        prefix = ["setpriv", f"--bounding-set={CAPABILITIES}"]
        bare.run(["/autograder/run_autograder"], prefix=prefix)
        result = json.loads((place / "results" / "results.json").read_text("utf-8"))
        seconds = time.monotonic() - start
        print(f"{what}: {result['score']:g} points in {seconds:.1f} s; {result['output']}")
        print(f"    {result['tests'][0]['output'].splitlines()[0][:160]}")


# --- Codespaces, Binder, JupyterHub ----------------------------------------------------------


def container(bare: Bare, work: Path) -> None:
    """Follow the Dockerfile and the devcontainer of a release."""
    release = work / "release"
    _run([*COURSE, "release", str(release), "--exercise", "1"])
    bare.run(["apt-get", "update"])
    packages = ["python3-venv", "python3-pip", "util-linux"]
    bare.run(["apt-get", "install", "-y", "--no-install-recommends", *packages])
    environment, folder, user = dockerfile(bare, release)
    for command in (
        "jupyter lab --version", "jupyter notebook --version", "jupyterhub-singleuser --version",
        "course list", "ls notebooks",
    ):  # fmt: skip
        said = _as(bare, user, environment, folder, command)
        print(f"{command}: {said.strip().splitlines()[-1][:100]}")
    about = json.loads((release / ".devcontainer" / "devcontainer.json").read_text("utf-8"))
    place = bare.folder / "workspaces" / "course"
    shutil.copytree(release, place)
    _run(["chown", "-R", environment["NB_UID"], str(place)])
    start = time.monotonic()
    _as(bare, about["remoteUser"], environment, "/workspaces/course", about["postCreateCommand"])
    print(f"postCreateCommand: {time.monotonic() - start:.0f} s")
    skeleton = "exercises/obstacle_avoidance/obstacle_avoidance_agent.py"
    command = f"course grade 1 {skeleton} --only wiring --json - || true"
    said = _as(bare, about["remoteUser"], environment, "/workspaces/course", command)
    print(f"a skeleton is graded: {'wiring' in said}")


def dockerfile(bare: Bare, release: Path) -> tuple[dict[str, str], str, str]:
    """Follow a Dockerfile but for FROM; return the environment, the folder and the user."""
    text = (release / "Dockerfile").read_text("utf-8")
    text = re.sub(r"(?m)^#.*\n", "", text).replace("\\\n", " ")
    known: dict[str, str] = {"PATH": PATHS}
    shown: dict[str, str] = {"PATH": PATHS}
    folder, user = "/", "root"
    for line in filter(None, map(str.strip, text.splitlines())):
        word, _, rest = line.partition(" ")
        filled = _filled(rest, known)
        start = time.monotonic()
        match word:
            case "ARG" | "ENV":
                said = dict(each.split("=", 1) for each in shlex.split(filled))
                known |= said
                shown |= said if word == "ENV" else {}
            case "USER":
                user = filled
            case "WORKDIR":
                folder = filled
            case "COPY":
                *options, _, target = filled.split()
                inside = bare.folder / target.lstrip("/")
                shutil.copytree(release, inside, dirs_exist_ok=True)
                owner = options[0].partition("=")[2]
                _run(["chown", "-R", owner, str(inside)])
            case "RUN":
                _as(bare, user, shown, folder, filled)
            case "FROM" | "EXPOSE" | "CMD":
                pass
            case _:
                raise SystemExit(f"Dockerfile: {word} is not known here")
        print(f"{word} {' '.join(filled.split())[:70]}: {time.monotonic() - start:.0f} s")
    return shown, folder, user


def _filled(text: str, known: Mapping[str, str]) -> str:
    return re.sub(r"\$\{(\w+)\}", lambda found: known[found[1]], text)


def _as(bare: Bare, user: str, environment: Mapping[str, str], folder: str, command: str) -> str:
    inner = f"cd {shlex.quote(folder)} && {command}"
    keep = ["setpriv", f"--reuid={user}", "--regid=1000", "--clear-groups"]
    prefix = [] if user == "root" else keep
    return bare.run(["sh", "-c", inner], environment=environment, prefix=prefix)


# --- commands --------------------------------------------------------------------------------


def _folders(value: str) -> list[str]:
    """Return the folders of this machine that a setting of pip's names."""
    words = [word.removeprefix("file://") for word in value.split()]
    return [word.removesuffix("/simple") for word in words if Path(word).is_dir()]


def _run(command: Sequence[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    if done.returncode:
        words = " ".join(command)[-300:]
        raise SystemExit(f"{words}\n{(done.stdout + done.stderr)[-4000:]}\nexit {done.returncode}")
    return done.stdout + done.stderr


if __name__ == "__main__":
    sys.exit(main())
