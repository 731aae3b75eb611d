"""Programs of tools/ are run from there: their folder comes before others."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
