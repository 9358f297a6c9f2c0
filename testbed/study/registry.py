"""All studies of this package, found by looking: a file that defines a `Study` with a name is enough."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from functools import cache

import testbed.study
from testbed.study.study import Study


def _modules() -> Iterator[str]:
    for info in pkgutil.walk_packages(testbed.study.__path__, "testbed.study."):
        if not info.name.endswith(".__main__"):
            yield info.name


@cache
def studies() -> dict[str, Study]:
    """Every study by name, sorted. ValueError if two share a name."""
    found: dict[str, Study] = {}
    for module in sorted(_modules()):
        for _, kind in inspect.getmembers(importlib.import_module(module), inspect.isclass):
            if not issubclass(kind, Study) or inspect.isabstract(kind) or kind.__module__ != module:
                continue
            if kind.name in found:
                raise ValueError(
                    f"study name {kind.name!r} is used by {type(found[kind.name]).__module__} and {module}"
                )
            found[kind.name] = kind()
    return dict(sorted(found.items()))


def find_study(name: str) -> Study:
    """The study of that name. ValueError lists the valid ones."""
    found = studies()
    if name not in found:
        raise ValueError(f"unknown study {name!r}; valid: {', '.join(found)}")
    return found[name]
