"""Many drives, one answer: the campaign file, the engine that runs its drives and never loses one, the judgement, the
report."""
