"""Study `tpms-leak`: what the seed's leak detector does, and what one with a designed false-alarm rate does."""
