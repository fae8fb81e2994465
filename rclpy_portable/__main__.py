"""Make the runtime ready, or run a program with it.

python -m rclpy_portable unpack [FOLDER_WITH_WHEELS]
python -m rclpy_portable run FILE [ARGUMENT …]
"""

from __future__ import annotations

import runpy
import shutil
import sys
from pathlib import Path

from . import activate, unpacking
from .wheels import DownloadFailed


def main(arguments: list[str]) -> int:
    """Do what the command line says; return the exit status."""
    try:
        match arguments:
            case ["unpack", *source] if len(source) < 2:
                shutil.rmtree(unpacking.FOLDER, ignore_errors=True)
                unpacking.unpack(unpacking.FOLDER, *map(Path, source))
                print(unpacking.FOLDER)
            case ["run", file, *_]:
                activate()
                sys.argv = arguments[1:]
                sys.path.insert(0, str(Path(file).resolve().parent))
                runpy.run_path(file, run_name="__main__")
            case _:
                print(__doc__, file=sys.stderr)
                return 2
    except DownloadFailed as error:
        print(f"rclpy_portable: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
