"""A program sees only the modules that it imports, though its host has imported many before.

`import rclpy` brings no `rclpy.node`. A host that needs it itself would show it to the program all
the same, and a node would run here that starts on no robot. So

1. `watch`: while the host warms up, note what the top level of each module imports;
2. `enter`: before the program starts, set aside all modules that `python3 FILE` begins without,
   and take them off the packages on which their import has put them;
3. from then on an import hands out the very module, with all that it imported in its turn.

A file beside the program goes first, as in Python. Where a module that the host needs imports one
of that name, Python would run it with the file: that is tried, and may fail as on a robot.

Nothing may be imported here that `python3` does not begin with: it would not be noted.
"""

from __future__ import annotations

import _frozen_importlib
import _imp
import builtins
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator
    from types import ModuleType
    from typing import Any

MISSING = object()
MODULE = type(sys)
MADE = (type, type(lambda: 0))  # classes and functions
OURS = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120  (pathlib: see above)
ROOT = os.path.dirname(os.path.dirname(OURS))  # noqa: PTH120
# Python's traceback reaches one through `collections`; datetime's clock looks in `sys.modules` for
# the other, and reads real time where it isn't there.
NEEDED = frozenset({"collections.abc", "time_machine"})


class Imports:
    """Which modules a host has imported, and which of them its program has."""

    def __init__(self) -> None:
        self._bare: frozenset[str] = frozenset()  # that every program begins with
        self._own: frozenset[str] = frozenset()  # that the host itself needs
        self._imported: dict[str, set[str]] = {}  # by each module's top level
        self._wanted: dict[str, dict[str, list[str]]] = {}  # by compiled modules, of others
        self._left: dict[str, dict[str, Any]] = {}  # what the top level of a package has left
        self._late: list[tuple[dict[str, Any], str, Any, str]] = []  # put on packages after that
        self._late_of: dict[str, tuple[dict[str, Any], str]] = {}
        self._running: list[str] = []  # modules whose top level runs
        self._aside: dict[str, Any] = {}  # modules that the program has not imported
        self._hidden: frozenset[str] = frozenset()
        self._folders: list[str] = []  # the programs'
        self._beside: set[str] = set()  # modules of whose name there is another in a folder
        self._trying = False
        self._end_watch: Any = None

    # ------------------------------------------------------------------------------- warming up

    def watch(self) -> None:
        """Note from now on what modules import; nothing but Python itself is imported yet."""
        self._bare = frozenset(
            n for n in sys.modules if n.partition(".")[0] != "rclpy_virtual_time"
        )
        for name in self._bare:
            self._note_left(name)
        python: Any = _frozen_importlib
        suffixes, noting = tuple(_imp.extension_suffixes()), self._noting()
        noted: list[Any] = []  # modules of the class `noting`
        real_import, real_load = builtins.__import__, python._load_unlocked
        real_absolute = python._gcd_import

        def load(spec: Any) -> Any:
            self._note(spec.name)
            self._imported.setdefault(spec.name, set())
            self._running.append(spec.name)
            if str(spec.origin).endswith(suffixes):
                self._wanted[spec.name] = {}
            try:
                module = real_load(spec)
            finally:
                self._running.pop()
                while spec.name in self._wanted and noted:
                    noted.pop().__class__ = MODULE
            self._note_left(spec.name)
            return module

        def import_(
            name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0
        ) -> Any:
            module = real_import(name, globals, locals, fromlist, level)
            if self._running:
                if level:
                    package = python._calc___package__(globals)
                    name = python._resolve_name(name, package, level)
                self._note(name)
                if self._running[-1] in self._wanted and type(module) is MODULE:
                    module.__class__ = noting
                    noted.append(module)
                for part in _named(module, fromlist):
                    if _is_module(module, f"{name}.{part}", part):
                        self._note(f"{name}.{part}")
            return module

        def absolute(name: str, package: Any = None, level: int = 0) -> Any:
            module = real_absolute(name, package, level)
            self._note(python._resolve_name(name, package, level) if level else name)
            return module

        def end() -> None:
            builtins.__import__ = real_import
            python._load_unlocked, python._gcd_import = real_load, real_absolute

        builtins.__import__ = import_
        python._load_unlocked, python._gcd_import = load, absolute
        self._end_watch = end

    def warm(self) -> None:
        """All has been imported that the host itself needs: what comes now is for programs."""
        self._own = frozenset(sys.modules)

    def settle(self) -> None:
        """End the watch: all has been imported that the host needs."""
        if self._end_watch is None:
            return
        self._end_watch()
        suffixes = tuple(_imp.extension_suffixes())
        for name, module in list(sys.modules.items()):
            parent = name.rpartition(".")[0]
            if name not in self._imported and parent in self._imported:
                self._imported[parent].add(name)  # no file of its own: `typing.io`
            elif str(_origin(module)).endswith(suffixes):  # such an import may pass unseen
                found = [v for v in vars(module).values() if type(v) is MODULE]
                noted = self._imported.setdefault(name, set())
                noted.update(v.__name__ for v in found if sys.modules.get(v.__name__) is v)
        for name, left in self._left.items():
            self._find_late(name, left)

    def lay_aside(self, owners: Collection[str]) -> None:
        """Set aside what only programs need, before hosts are forked.

        Each host would write to a thousand pages for it, which Linux copies first. `owners` are the
        packages whose modules, with all that they import, a host may need before its program.
        """
        theirs = [name for name in sys.modules if name.partition(".")[0] in owners]
        self._set_aside(self._own.union(*map(self._reached, theirs)))

    def _set_aside(self, kept: frozenset[str]) -> None:
        """Take all other modules from the host, and off the packages on which they were put."""
        kept = self._bare | NEEDED | kept
        for name in [n for n in sys.modules if n not in kept]:
            self._aside.setdefault(name, sys.modules.pop(name))
        late, self._late = self._late, []
        for names, key, before, name in late:
            if name not in self._aside or names.get(key) is not self._aside[name]:
                self._late.append((names, key, before, name))
            elif before is MISSING:
                del names[key]
            else:
                names[key] = before

    def _note(self, name: str) -> None:
        if self._running and self._running[-1] != name:
            self._imported.setdefault(self._running[-1], set()).add(name)

    def _noting(self) -> type[ModuleType]:
        """Return a class of modules that notes what compiled code takes from one while it loads."""

        class Noting(MODULE):  # type: ignore[misc,valid-type]
            def __getattribute__(module, key: str) -> Any:  # noqa: N805
                wanted = self._wanted.get(self._running[-1]) if self._running else None
                if wanted is not None and not key.startswith("__"):
                    name = MODULE.__getattribute__(module, "__name__")
                    wanted.setdefault(name, []).append(key)
                return MODULE.__getattribute__(module, key)

        return Noting

    def _note_left(self, name: str) -> None:
        names = getattr(sys.modules.get(name), "__dict__", {})
        if "__path__" in names or "__getattr__" in names:
            self._left[name] = dict(names)

    def _find_late(self, package: str, left: dict[str, Any]) -> None:
        """Note what was put on a package after its top level had run."""
        names = vars(sys.modules[package])
        for key, value in list(names.items()):
            if left.get(key, MISSING) is value:
                continue
            name = f"{package}.{key}"
            if name not in self._bare and sys.modules.get(name, MISSING) is value:
                self._late.append((names, key, left.get(key, MISSING), name))
            elif key not in left and "__getattr__" in left and not key.startswith("__"):
                del names[key]
                if _made_when_asked_for(left["__getattr__"], key) is not value:
                    names[key] = value
                else:
                    names.pop(key, None)  # it is made again
        self._late_of = {name: (names, key) for names, key, _, name in self._late}

    # ------------------------------------------------------------------------------ the program

    def enter(self, folders: Iterable[str]) -> None:
        """Let the programs of these folders have what `python3` begins with."""
        self._folders = list(folders)
        sys.path[:0] = [folder for folder in self._folders if folder not in sys.path]
        if self in sys.meta_path or self._end_watch is None:
            return
        self._set_aside(frozenset())
        if ROOT in sys.path and ROOT not in self._folders:
            sys.path.remove(ROOT)
        sys.meta_path.insert(0, self)
        self._beside = {name for name in self._names_beside() if self._is_another(name)}
        if self._beside:
            for name in [n for n in self._aside if n.partition(".")[0] in self._beside]:
                del self._aside[name]

    def leave(self) -> None:
        """The program is over: nothing is hidden from the host any more."""
        for name in list(self._aside):
            self.give(name)

    def hide(self, names: Collection[str]) -> None:
        """Let imports of these top-level modules fail, as if they were not installed."""
        if not names:
            return
        self._hidden = hidden = self._hidden.union(names)
        for name in [n for n in sys.modules if n.partition(".")[0] in hidden]:
            del sys.modules[name]
        others = [_Blind(finder, hidden) for finder in self._others()]
        sys.meta_path[:] = [*([self] if self in sys.meta_path else []), *others]

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        """Return how a module that lies aside is loaded; None if it doesn't."""
        if name not in self._aside or name.partition(".")[0] in self._hidden:
            return None
        module = self._aside[name]
        spec = self._find_elsewhere(name, path, target)
        if spec is not None and self._is_other(module, spec):
            for other in [n for n in self._aside if f"{n}.".startswith(f"{name}.")]:
                del self._aside[other]
            return spec
        alone = False
        if self._beside and not self._beside.isdisjoint(self._reached(name)):
            if not self._trying:
                self._try(name)
            elif spec is not None and str(spec.origin).endswith(".py"):
                return spec
            else:
                alone = True
                self._take_wanted(name)
        if spec is None:  # the host's own, or made without a file
            spec = _frozen_importlib.ModuleSpec(name, None, origin=_origin(module))
        spec.loader = _HandOut(None if alone else self, name, module, spec.loader)
        return spec

    def give(self, name: str) -> None:
        """Give a module to the program, with all that came with it."""
        waiting = [name]
        while waiting:
            name = waiting.pop()
            if name not in self._aside or name.partition(".")[0] in self._hidden:
                continue
            module = sys.modules[name] = self._aside.pop(name)
            if name in self._late_of:
                names, key = self._late_of[name]
                names[key] = module
            waiting += [name.rpartition(".")[0], *self._imported.get(name, ())]

    def hiding_file(self, error: BaseException) -> str:
        """Return the file in a program's folder that was imported for another; "" if none was.

        The error says which module it misses something in; or it was raised while the top level of
        the file ran because a library had asked for a module of that name.
        """
        top = _module_of(error).partition(".")[0]
        if top:
            file = str(getattr(self._find_elsewhere(top), "origin", ""))
            if self.is_beside(file) and self._find_elsewhere(top, self._other_folders()):
                return file
        before = ""
        for frame in _frames(error):
            file = frame.f_code.co_filename
            if file.startswith("<") or os.path.dirname(file) == OURS:  # noqa: PTH120
                continue  # frozen, or what starts an entry point
            runs = frame.f_code.co_name == "<module>" and self.is_beside(file)
            if runs and before and not self.is_beside(before):
                return str(file)
            before = file
        return ""

    def _try(self, name: str) -> None:
        """Import a module as `python3` would here, with what lies beside it; undo it.

        (The host has replaced parts of some modules: a second one would not do.)
        """
        before = set(sys.modules)
        self._trying = True
        try:
            __import__(name)
        except Exception as error:
            if self.hiding_file(error):
                raise
        finally:
            self._trying = False
            for other in set(sys.modules) - before:
                if other in self._aside:
                    self._bind_files(sys.modules.pop(other), self._aside[other])

    def _bind_files(self, tried: Any, ours: Any) -> None:
        """Let a module use what it has got from files beside the program when it was tried."""
        files = [sys.modules.get(name, MISSING) for name in self._beside]
        for key, value in list(getattr(tried, "__dict__", {}).items()):
            made = isinstance(value, MADE) and value.__module__ in self._beside
            if made or any(value is file for file in files):
                vars(ours)[key] = value

    def _take_wanted(self, name: str) -> None:
        """Take from files of the program what a compiled module took from others of that name."""
        for other, keys in self._wanted.get(name, {}).items():
            if other in self._beside:
                for key in keys:
                    getattr(__import__(other), key)

    def _reached(self, name: str) -> set[str]:
        """Return a module and all that came with it."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            name = waiting.pop()
            if name and name not in found:
                found.add(name)
                waiting += [name.rpartition(".")[0], *self._imported.get(name, ())]
        return found

    def _names_beside(self) -> set[str]:
        found: set[str] = set()
        for folder in self._folders:
            try:
                entries = os.listdir(folder)  # noqa: PTH208
            except OSError:
                continue
            found.update(entry.partition(".")[0] for entry in entries)
        return found & self._aside.keys()

    def _is_another(self, name: str) -> bool:
        spec = self._find_elsewhere(name)
        return spec is not None and self._is_other(self._aside[name], spec)

    def _is_other(self, module: ModuleType, spec: Any) -> bool:
        """Return whether a file holds another module than the host's, not a second copy of it."""
        mine, origin = str(_origin(module)), str(spec.origin)
        return mine != origin and (self.is_beside(origin) or not mine.startswith(f"{ROOT}/"))

    def is_beside(self, file: str) -> bool:
        """Return whether a file lies in a program's folder."""
        return any(file.startswith(os.path.join(folder, "")) for folder in self._folders)

    def _other_folders(self) -> list[str]:
        return [entry for entry in sys.path if entry not in self._folders]

    def _others(self) -> list[Any]:
        return [finder for finder in sys.meta_path if finder is not self]

    def _find_elsewhere(self, name: str, path: Any = None, target: Any = None) -> Any:
        """Return what the other finders find."""
        for finder in self._others():
            spec = finder.find_spec(name, path, target) if hasattr(finder, "find_spec") else None
            if spec is not None:
                return spec
        return None


class _HandOut:
    """A loader that has its module already; for anything else it is the module's own."""

    def __init__(self, giver: Imports | None, name: str, module: Any, loader: Any) -> None:
        self._giver, self._name, self._module, self._loader = giver, name, module, loader
        self._spec = getattr(module, "__spec__", None)

    def create_module(self, spec: Any) -> Any:
        """Return the module."""
        return self._module

    def exec_module(self, module: ModuleType) -> None:
        """Run nothing: it has run."""
        try:  # noqa: SIM105  (contextlib: see above)
            module.__spec__ = self._spec
        except AttributeError:  # an object in a module's place
            pass
        if self._giver is not None:
            self._giver.give(self._name)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)


class _Blind:
    """A finder of modules that does not find some."""

    def __init__(self, finder: Any, hidden: frozenset[str]) -> None:
        self._finder, self._hidden = finder, hidden

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        """Return the module's spec; None if there is none, or none to be seen."""
        if name.partition(".")[0] in self._hidden:
            return None
        return self._finder.find_spec(name, path, target)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._finder, name)


def place_of(code: Any, line: int) -> str:
    """Return where a line of a program is."""
    return f"{os.path.basename(code.co_filename)}, line {line}"  # noqa: PTH119


def _named(module: Any, fromlist: Iterable[str] | None) -> Iterator[str]:
    for name in fromlist or ():
        if name == "*":
            yield from getattr(module, "__all__", ())
        else:
            yield name


def _is_module(package: Any, name: str, part: str) -> bool:
    return name in sys.modules and getattr(package, part, None) is sys.modules[name]


def _origin(module: Any) -> Any:
    return getattr(getattr(module, "__spec__", None), "origin", None)


def _made_when_asked_for(getter: Any, key: str) -> Any:
    try:
        return getter(key)
    except Exception:
        return MISSING


def _module_of(error: BaseException) -> str:
    """Return the name of the module that an import or an attribute is missed in; "" if none is."""
    if isinstance(error, ImportError):
        return error.name or ""
    if isinstance(error, AttributeError) and type(error.obj) is MODULE:
        return error.obj.__name__
    return ""


def _frames(error: BaseException) -> Iterator[Any]:
    trace = error.__traceback__
    while trace is not None:
        yield trace.tb_frame
        trace = trace.tb_next


host = Imports()
