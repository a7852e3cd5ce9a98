"""``explore``: a page whose sliders are answered by passages."""

from __future__ import annotations

import asyncio
import threading
import webbrowser
from collections.abc import Sequence

from ..errors import InputError
from ..scenario import load_scenario

HIGHEST_PORT = 65535


def explore(name: str, changes: Sequence[str], port: int, *, browser: bool) -> int:
    """Serve the page until it is interrupted; returns the exit status."""
    if not 0 <= port <= HIGHEST_PORT:
        raise InputError(f"--port {port} is out of range: give 1 to {HIGHEST_PORT}, or 0 for a free one")
    scenario = load_scenario(name, changes)
    try:
        from ..explore.server import serve
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in ("bokeh", "tornado"):
            raise
        raise InputError(
            f"the page needs {missing.name}, which is not installed: run python3 tools/setup_env.py explore, or "
            "pip install bokeh"
        ) from None

    def opened(address: str) -> None:
        print(f"{address}\nEnd with Ctrl-C.", flush=True)  # noqa: T201
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    asyncio.run(serve(scenario, port, opened=opened))
    return 0
