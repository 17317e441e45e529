"""What tests of searches share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.search import searches


@pytest.fixture
def folder() -> Iterator[Path]:
    with searches.folder() as place:
        yield place
