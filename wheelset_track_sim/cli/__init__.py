"""The command line: one module for each command."""

from .command_line import main

__all__ = ["main"]
