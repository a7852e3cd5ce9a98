"""What tests of several folders share: places, a toy, runs of plain numbers, slow independent methods."""

from pathlib import Path

import pytest

# A comparison that fails in one of these modules shows its values, as in a test.
pytest.register_assert_rewrite(*(f"{__name__}.{path.stem}" for path in Path(__file__).parent.glob("[!_]*.py")))
