"""What a recording holds, for tests: rows of an entity, and what its layout asks for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
from rerun.chunk import RrdReader


def rows(path: Path, entity: str) -> list[pa.RecordBatch]:
    chunks = [c for c in RrdReader(path).stream().to_chunks() if c.entity_path == entity and not c.is_static]
    return [chunk.to_record_batch() for chunk in chunks]


def flat(batch: pa.RecordBatch, component: str) -> np.ndarray:
    array = batch.column(component).flatten()
    return np.asarray(array.flatten() if pa.types.is_fixed_size_list(array.type) else array)


def layout(path: Path) -> tuple[set[str], set[str]]:
    """What a recording's blueprint asks for: the entities of its views, and the one its camera follows."""
    reader = RrdReader(path)
    (blueprint,) = reader.blueprints()
    asked: set[str] = set()
    followed: set[str] = set()
    for chunk in reader.stream(store=blueprint).to_chunks():
        batch = chunk.to_record_batch()
        for name, found in (("ViewContents:query", asked), ("EyeControls3D:tracking_entity", followed)):
            if name in batch.schema.names:
                found |= set(batch.column(name).flatten().to_pylist())
    return asked, followed
