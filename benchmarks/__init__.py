"""How fast each part is beside its floor: what `make bench` measures. Nothing here is a test."""
