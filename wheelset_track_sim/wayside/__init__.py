"""Detectors beside the track: where their gauges are, what they read while a wheelset passes, what they make of it."""
