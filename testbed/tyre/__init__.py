"""The tyre as a force element: enveloping, vertical law, slip forces, relaxation, inflation."""
