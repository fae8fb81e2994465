"""The budget of lines (.ci/budget.py), in a small repository of its own."""

import shutil
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / ".ci/budget.py"
BUDGET = 'Python = { files = ["*.py", ":!*skipped.py"], most = 42 }\n'


def counted(folder: Path, lines: int) -> subprocess.CompletedProcess[str]:
    """Return what the script says of a repository with so many lines of Python beside its own."""
    (folder / ".ci").mkdir()
    script = shutil.copy(SCRIPT, folder / ".ci/skipped.py")
    (folder / ".ci/budget.toml").write_text(BUDGET)
    (folder / "node.py").write_text("pass\n" * lines)
    (folder / "untracked.py").write_text("pass\n" * 100)
    for command in (["init", "-q"], ["add", "node.py", ".ci"]):
        subprocess.run(["git", *command], cwd=folder, check=True)
    return subprocess.run([sys.executable, script], check=False, capture_output=True, text=True)


def test_as_many_lines_as_the_budget_has_pass(tmp_path):
    done = counted(tmp_path, 42)
    assert (done.returncode, done.stdout.strip()) == (0, "lines of Python          42 of 42")


def test_one_line_more_is_refused_with_the_number(tmp_path):
    done = counted(tmp_path, 43)
    assert (done.returncode, "1 too many (.ci/budget.toml)" in done.stdout) == (1, True)
