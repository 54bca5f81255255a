"""What a saved policy comes from."""

import hashlib
from pathlib import Path

from pipeline.data.lineage import Lineage, Recipe
from pipeline.policies.loading import begun_with


def made(purpose: str, *parents: Lineage) -> Lineage:
    name = f"{purpose} of {[parent.sha256 for parent in parents]}"
    return Recipe(purpose, {}, parents).lineage(hashlib.sha256(name.encode()).hexdigest())


def test_of_forty_iterations_the_first_primary_is_what_the_loop_began_with(tmp_path: Path) -> None:
    """Each looked for once: by way of all that it comes from there are some 4^40 ways to it."""
    d_safe, data = made("D_safe"), made("D_0")
    first = primary = made("primary", data)
    for _ in range(40):
        rollout = made("rollout", primary, made("safety", primary, d_safe, data))
        data = made("merge", data, made("select", rollout))
        primary = made("primary", data, primary)
    (tmp_path / "model.safetensors").write_bytes(b"weights")
    weights = hashlib.sha256(b"weights").hexdigest()
    Recipe("primary", {}, [data, primary]).lineage(weights).write(tmp_path)
    assert begun_with(tmp_path) == first.sha256
