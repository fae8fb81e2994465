"""Run the tests of rclpy and of CPython in plain Python and in a host, and review what differs.

    python -m rclpy_virtual_time.conform rclpy CHECKOUT [MODULE …]
    python -m rclpy_virtual_time.conform cpython [MODULE …]

The checkout is of ros2/rclpy at the tag of the installed wheels. Exit status 1: something differs
that the reviewed list does not know, or no longer differs as the list says.
"""

import argparse
import signal
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec

from rclpy_virtual_time.conform import suites
from rclpy_virtual_time.conform.review import Difference, Review, differences, read_list, review
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.settings import EPOCH

KEPT = Path("build/conform")  # what was found, in full


def main(arguments: Sequence[str]) -> int:
    """Do what the command line says; return the exit status."""
    options = _options(arguments)
    # Where it is ignored, as in the background of a script, tests that wait for it would hang.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        checkout = Path(options.path).resolve() if options.suite == "rclpy" else None
        return run_suite(options.suite, checkout, options.modules)
    except EngineError as error:
        print(error, file=sys.stderr)
        return 2


def run_suite(suite: str, checkout: Path | None, chosen: Sequence[str] = ()) -> int:
    """Run a suite, or those of its modules whose names have one of `chosen` in them."""
    modules = suites.cpython_modules() if checkout is None else suites.rclpy_modules(checkout)
    plain: dict[str, str] = {}
    inside: dict[str, str] = {}
    texts: dict[str, str] = {}
    with ForkServer(EPOCH, layers=suites.LAYERS[suite]) as forkserver:
        suites.check_unprivileged(forkserver)
        for module in modules:
            if chosen and not any(word in module for word in chosen):
                continue
            real, virtual = suites.run_module(suite, module, forkserver, checkout)
            found = differences(real.outcomes, virtual.outcomes, {})
            print(f"{module}: {len(virtual.outcomes)} tests, {len(found)} differ", flush=True)
            plain |= real.outcomes
            inside |= virtual.outcomes
            texts |= real.texts | {t: text for t, text in virtual.texts.items() if text}
    return _judge(suite, plain, inside, texts)


def _judge(suite: str, plain: dict[str, str], inside: dict[str, str], texts: dict[str, str]) -> int:
    """Keep what was found, print what the list says of it, return the exit status."""
    found = differences(plain, inside, texts)
    KEPT.mkdir(parents=True, exist_ok=True)
    kept = {"plain": plain, "inside": inside, "differences": found}
    (KEPT / f"{suite}.json").write_bytes(msgspec.json.format(msgspec.json.encode(kept)))
    result = review(found, plain.keys() | inside.keys(), read_list(suite))
    _print(plain, inside, result)
    return 0 if result.passed else 1


def _print(plain: dict[str, str], inside: dict[str, str], result: Review) -> None:
    print(f"\nplain:  {_counts(plain)}\ninside: {_counts(inside)}")
    print(f"\n{len(result.meant)} differences are meant")
    reasons = Counter(entry.reason for _, entry in result.meant)
    print("".join(f"{count:5}  {reason}\n" for reason, count in reasons.most_common()), end="")
    _print_list("not in the list", [_in_full(difference) for difference in result.unlisted])
    _print_list("in the list, but no longer different", result.stale)
    _print_list("failed in plain Python only, where real time comes late", result.late)


def _in_full(difference: Difference) -> str:
    return f"{difference}\n" + "".join(f"      {s}\n" for s in difference.text.splitlines()[-8:])


def _print_list(title: str, lines: Sequence[str]) -> None:
    print(f"\n{title}: {len(lines) or 'none'}")
    print("".join(f"  {line}\n" for line in lines), end="")


def _counts(outcomes: dict[str, str]) -> str:
    return ", ".join(f"{n} {outcome}" for outcome, n in Counter(outcomes.values()).most_common())


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="rclpy_virtual_time.conform",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = parser.add_subparsers(dest="suite", required=True)
    rclpy = kinds.add_parser("rclpy")
    rclpy.add_argument("path", help="a checkout of ros2/rclpy")
    rclpy.add_argument("modules", nargs="*")
    kinds.add_parser("cpython").add_argument("modules", nargs="*")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
