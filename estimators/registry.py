"""All estimators of this package, found by looking: a file that defines an `Estimator` with a name is enough."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterable
from functools import cache

import estimators
from estimators.estimator import Estimator

FORBIDDEN = ("truth/", "est/", "alarm/")
_NOT_METHODS = ("estimators.readers", "estimators.__main__")  # file formats and the command line define no method


@cache
def registered() -> dict[str, type[Estimator]]:
    """Estimator classes by name, sorted. ValueError if two share a name or one declares a signal it may not read."""
    found: dict[str, type[Estimator]] = {}
    for module_name in sorted(_module_names()):
        module = importlib.import_module(module_name)
        for _, kind in inspect.getmembers(module, inspect.isclass):
            if not issubclass(kind, Estimator) or inspect.isabstract(kind) or kind.__module__ != module_name:
                continue
            check_declaration(kind)
            if kind.name in found:
                raise ValueError(
                    f"estimator name {kind.name!r} is used by {found[kind.name].__module__} and {module_name}"
                )
            found[kind.name] = kind
    return dict(sorted(found.items()))


def _module_names() -> Iterable[str]:
    pending: list[tuple[list[str], str]] = [(list(estimators.__path__), "estimators.")]
    while pending:
        path, prefix = pending.pop()
        for info in pkgutil.iter_modules(path, prefix):
            if info.name in _NOT_METHODS:
                continue
            yield info.name
            if info.ispkg:
                pending.append((list(importlib.import_module(info.name).__path__), info.name + "."))


def check_declaration(kind: type[Estimator]) -> None:
    """ValueError if `kind` declares what an estimator may not read, or requires what it does not declare."""
    for signal in kind.reads:
        if signal.startswith(FORBIDDEN):
            raise ValueError(f"estimator {kind.name} declares {signal!r}; no estimator may read {', '.join(FORBIDDEN)}")
    undeclared = {*kind.requires, *kind.requires_any} - set(kind.reads)
    if undeclared:
        raise ValueError(f"estimator {kind.name} requires {sorted(undeclared)} but does not declare to read it")


def select(names: Iterable[str] | None = None) -> dict[str, type[Estimator]]:
    """The named estimators, all if None. ValueError lists the valid names."""
    known = registered()
    if names is None:
        return known
    for name in names:
        if name not in known:
            raise ValueError(f"no estimator {name!r}, valid: {', '.join(known)}")
    return {name: known[name] for name in names}
