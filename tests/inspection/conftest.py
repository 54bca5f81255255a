import pytest

from pipeline.policies.inference import Driver
from tests.drives import untrained


@pytest.fixture(scope="session")
def driver() -> Driver:
    """Does not brake."""
    return untrained(brake_cut=1.0)
