"""``python -m wheelset_track_sim`` is the command line."""

import sys

from .cli import main

sys.exit(main())
