"""Deviations of treads and rails from their nominal surfaces: one small class each, one protocol."""
