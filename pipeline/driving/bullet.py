"""PyBullet, without the build time that it prints on stderr when it is imported."""

import os
from types import ModuleType


def _import_quietly() -> ModuleType:
    stderr = os.dup(2)
    try:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), 2)
        import pybullet

        return pybullet
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)


pybullet = _import_quietly()
