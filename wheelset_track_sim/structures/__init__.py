"""Wheelset and track: geometry, finite elements, modes, receptances and reduced models."""
