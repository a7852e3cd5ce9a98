"""Decimated topics, as another process receives them, against the bag of the same run at full rate."""

import signal
from itertools import pairwise

import numpy as np
import pytest

from wheelset_track_sim.bags import blocks, read_bag
from wheelset_track_sim.samples.decimation import REACH, decimated
from wheelset_track_sim.samples.principal import maximum_principal

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

FORCES, STRESS = 10, 25


def by_step(chunks, factor):
    """Chunks without gaps as the step of the first sample and all of them."""
    following = chunks[0].first_step
    for chunk in chunks:
        assert (chunk.first_step, chunk.decimation) == (following, factor)
        following = chunk.first_step + factor * len(samples(chunk))
    return chunks[0].first_step // factor, np.concatenate([samples(chunk) for chunk in chunks])


def samples(chunk):
    if hasattr(chunk, "wheel_1"):
        return np.stack([chunk.wheel_1, chunk.wheel_2], axis=1)
    return np.stack([chunk.yy, chunk.max_principal], axis=1)


def test_decimated_topics_are_the_filtered_run_and_the_summary_keeps_its_peaks(start, client, tmp_path):
    forces = client.collect("contact_forces", "ContactForces")
    stress = client.collect("axle_stress/a1", "AxleStress")
    summaries = client.collect("summary", "LoadSummary")
    factors = {"contact_forces__decimation": FORCES, "axle_stress__decimation": STRESS}
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="damage_wheel_1", real_time_factor=2.0, **factors, **bag)
    client.until(lambda: forces and forces[-1].first_step > forces[0].first_step + 12_000 and stress)
    assert node.signal(signal.SIGINT) == 0, node.errors

    whole = read_bag(tmp_path / "run")  # at full rate, whatever is published
    np.testing.assert_array_equal(np.diff(whole.steps), 1)
    last = int(whole.steps[-1])
    client.until(lambda: forces[-1].first_step + FORCES * len(forces[-1].wheel_1) > last)  # the filter is emptied
    client.until(lambda: stress[-1].first_step + STRESS * len(stress[-1].yy) > last)

    thin = [*decimated(blocks(tmp_path / "run"), FORCES)]
    first, found = by_step(forces, FORCES)
    np.testing.assert_array_equal(found, np.concatenate([block.forces for block in thin])[first:])
    thin = [*decimated(blocks(tmp_path / "run"), STRESS)]
    first, found = by_step(stress, STRESS)
    a1 = np.concatenate([block.stresses[:, 0] for block in thin])[first:]
    np.testing.assert_array_equal(found[:, 0], a1[:, 1])
    np.testing.assert_allclose(found[:, 1], maximum_principal(a1), rtol=1e-12)

    chunk = forces[-2]
    assert chunk.step_period == pytest.approx(FORCES * whole.step_period[0], rel=1e-14)
    assert chunk.time == pytest.approx(whole.time[chunk.first_step], rel=1e-12)
    assert chunk.position == pytest.approx(whole.position[chunk.first_step], rel=1e-12)
    stamp = chunk.header.stamp.sec * 10**9 + chunk.header.stamp.nanosec
    assert stamp - whole.start_ns == pytest.approx(1e9 * chunk.time, abs=2)

    told = slice(summaries[0].first_step, summaries[-1].first_step + summaries[-1].samples)
    peak = max(summary.wheel_1_max_force for summary in summaries)
    assert peak == whole.forces[told, 0].max()
    assert peak > 1.05 * max(max(chunk.wheel_1) for chunk in forces)  # an impact is narrower than the filter
    assert max(summary.max_principal_max[0] for summary in summaries) == whole.max_principal[told, 0].max()
    assert max(summary.stress_max[1] for summary in summaries) == whole.stresses[told, 0, 1].max()


def test_decimation_changes_while_the_node_runs(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    stress = client.collect("axle_stress/c1", "AxleStress")
    start(scenario="undamaged", contact_forces__decimation=20)
    client.until(lambda: len(forces) >= 3 and stress)
    assert client.set(contact_forces__decimation=4).successful
    client.until(lambda: forces[-1].decimation == 4)
    assert not client.set(contact_forces__decimation=0).successful
    assert not client.set(axle_stress__decimation=1001).successful
    assert client.get("contact_forces.decimation", "axle_stress.decimation") == [4, 1]
    assert client.set(contact_forces__decimation=1).successful
    seen = len(forces)
    client.until(lambda: forces[-1].decimation == 1 and len(forces) > seen + 3)
    chunks = [*forces]
    assert {chunk.revision for chunk in chunks} == {0}  # what is published is no matter of the scenario
    for before, after in pairwise(chunks):
        end = before.first_step + before.decimation * len(before.wheel_1)
        if before.decimation == after.decimation:
            assert after.first_step == end
        else:  # the old filter is emptied, and the new one begins with the next multiple
            changed = end - before.decimation + 1
            assert changed <= after.first_step < end + after.decimation
            assert after.first_step % after.decimation == 0
    assert [chunk.decimation for chunk in stress] == [1] * len(stress)
    force = np.concatenate([chunk.wheel_1 for chunk in chunks])
    assert 90e3 < force.min() < force.max() < 105e3  # no transient of a filter


def test_a_decimated_topic_comes_late_by_half_the_filter(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    summaries = client.collect("summary", "LoadSummary")
    start(scenario="undamaged", contact_forces__decimation=100)
    client.until(lambda: len(forces) >= 5)
    behind = summaries[-1].first_step + summaries[-1].samples - forces[-1].first_step
    assert behind + 1389 >= REACH * 100  # the two topics need not arrive in step
    assert all(chunk.first_step % 100 == 0 for chunk in forces)
