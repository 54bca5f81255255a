"""Training of the primary and of the safety policy, its labels, and how good it is."""
