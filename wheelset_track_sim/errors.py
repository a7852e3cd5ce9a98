"""The family of errors that a caller can act on; everything else keeps its traceback."""


class WheelsetTrackError(Exception):
    """Base of all errors raised on purpose by this package; the command line ends with status 1."""


class InputError(WheelsetTrackError, ValueError):
    """Input that cannot be used; the command line ends with status 2.

    The message is one line: quantity, value, limit and remedy.
    """


class ContactError(WheelsetTrackError):
    """The contact problem of a step has no solution within the iteration bound, or is not finite."""


class RecordingError(WheelsetTrackError):
    """A bag cannot be written or read."""


class NoBagError(RecordingError, InputError):
    """There is no bag where one was said to be."""


class DivergenceError(WheelsetTrackError):
    """Forces, displacements or stresses of a step are not finite."""
