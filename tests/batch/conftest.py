import pytest


@pytest.fixture
def tally():
    """Collect what was tried: ``tally(section, what, outcome)``."""
    rows = []

    def add(section, what, outcome):
        rows.append((section, what, outcome))

    add.rows = rows
    return add
