"""The track: rails, sleepers, supports, their receptances and their models in a moving frame."""
