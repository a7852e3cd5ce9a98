"""Fatigue of the axle: rotating stress, rainflow counting and damage."""
