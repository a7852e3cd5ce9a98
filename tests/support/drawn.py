"""What property tests of several modules draw from."""

from hypothesis import strategies as st

from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import WHEELS

BREAKOUTS = st.builds(
    Breakout,
    on=st.sampled_from(WHEELS),
    a=st.floats(0.001, 0.2),
    b=st.floats(0.001, 0.02),
    h=st.floats(1e-6, 0.01),
    angle=st.floats(-6.0, 6.0),
    y=st.floats(-0.03, 0.03),
)
