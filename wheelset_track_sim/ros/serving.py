"""How services of nodes answer: always, whatever happens."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

from ..errors import WheelsetTrackError

Answer = dict[str, Any]
"""Fields of a response."""


def served(log: Any, answer: Callable[[Any], Answer], request: Any, response: Any) -> Any:
    """``response``, which has ``success`` and ``message``, with an answer, or with the reason why there is none."""
    try:
        fields = {"success": True, **answer(request)}
    except WheelsetTrackError as refusal:
        fields = {"success": False, "message": str(refusal)}
    except Exception as failure:  # noqa: BLE001  the executor must live, and the client must not wait
        log.fatal(traceback.format_exc())
        fields = {"success": False, "message": f"it failed, see the node's log: {failure!r}"}
    for name, value in fields.items():
        setattr(response, name, value)
    return response
