"""What NumPy's readers raise for bytes that are no file of theirs."""

from __future__ import annotations

import zlib
from tokenize import TokenError
from zipfile import BadZipFile

UNREADABLE = (
    *(ValueError, EOFError, LookupError, RuntimeError, ArithmeticError, TypeError, SyntaxError, MemoryError),
    *(BadZipFile, zlib.error, TokenError),
)
"""Errors of zip archives, and of heads that declare any type, size or Python expression."""
