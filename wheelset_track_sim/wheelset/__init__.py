"""The wheelset: geometry, finite elements, reduced model, stress nodes."""
