import os
import subprocess
import sys

import pytest

DRAW = 'import mujoco; mujoco.Renderer(mujoco.MjModel.from_xml_string("<mujoco/>")).close()'


@pytest.fixture(scope="session", autouse=True)
def drawing() -> None:
    """Nothing here works where nothing can be drawn; CI must be able to. In a process of its own,
    for what MuJoCo leaves behind when it fails.
    """
    tried = subprocess.run(
        [sys.executable, "-c", DRAW], capture_output=True, text=True, check=False
    )
    if tried.returncode:
        give_up = pytest.fail if "CI" in os.environ else pytest.skip
        give_up(f"MuJoCo cannot draw here: {tried.stderr.splitlines()[-1]}")
