"""The study `wheel-plausibility`: seed 004, chapter 6, on equivalent drives, and what meets its requirement."""
