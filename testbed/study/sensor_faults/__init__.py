"""Seed 003: faults of sensors found by analytical redundancy."""
