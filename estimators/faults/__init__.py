"""Faults of sensors on demand, on a stream or on a log. `parse_fault`, `Injector` and `inject` are the way in."""

from estimators.faults.fault import FORM, Fault, parse_fault
from estimators.faults.injector import Injector, inject
from estimators.faults.kind import fault_kinds
from estimators.faults.targets import known_targets

__all__ = ["FORM", "Fault", "Injector", "fault_kinds", "inject", "known_targets", "parse_fault"]
