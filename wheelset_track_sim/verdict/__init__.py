"""Verdicts: what a run reached, compared with limits that have a source."""
