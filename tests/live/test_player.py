"""The schedule of a replay by a clock that goes only while somebody sleeps: what is late then is late by design."""

import threading
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.bags.playback.recorded_bag import Played
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.player import Playback, Player

START = 1_700_000_000_123_456_789
MS = 10**6


class Clock:
    """Goes while it is slept by; at given times it does what is wanted, and stops the player when all is done."""

    epoch = 0

    def __init__(self, script=()):
        self.time, self.script = 17.0, sorted(script, key=lambda item: item[0])
        self.player = None

    def now(self):
        return self.time

    def sleep(self, due, wake):
        if wake.is_set():
            return
        if self.script and 17.0 + self.script[0][0] <= due:
            at, action = self.script.pop(0)
            self.time = max(self.time, 17.0 + at)
            action(self.player)
        elif not self.script and self.player.paused:
            self.player.stop()
        else:
            self.time = due


class Tape:
    """Messages at given times since START, ns; ``chunks`` of them begin one."""

    def __init__(self, times, every=1, tail=50 * MS):
        self.items = [
            Played(START + time, "x", bytes([number % 256]), number % every == 0) for number, time in enumerate(times)
        ]
        self.start_ns, self.end_ns = START, START + max(times) + tail

    def played(self, begin_ns, end_ns):
        return (item for item in self.items if begin_ns <= item.time_ns < end_ns)


class Session:
    """A player that has run to its end, and all that it did."""

    def __init__(self, tape, script=(), **playback):
        self.clock = Clock(script)
        self.out, self.moves, self.ends = [], [], []
        self.player = Player(
            tape,
            Playback(**playback),
            lambda item, played: self.out.append((self.clock.time - 17.0, item, played)),
            lambda begin, played: self.moves.append((begin, played)),
            self.ends.append,
            self.clock,
        )
        self.clock.player = self.player

    def run(self):
        self.player.run()
        return self

    @property
    def times(self):
        return [item.time_ns - START for _, item, _ in self.out]


class Ready:
    """Not ready a number of times; does something to the player when it is asked for the second time."""

    def __init__(self, session, after, action=lambda player: None):
        self.session, self.left, self.action = session, after, action
        self.asked = []

    def __call__(self):
        self.asked.append(self.session.player.paused)
        self.session.clock.time += 1.0
        if len(self.asked) == 2:
            self.action(self.session.player)
        self.left -= 1
        return self.left < 0


def test_it_is_held_until_it_is_ready():
    session = Session(Tape([0, 100 * MS]))
    ready = Ready(session, after=3)
    session.player.run(ready)
    assert ready.asked == [True] * 4  # paused meanwhile
    assert [now for now, _, _ in session.out] == pytest.approx([4.0, 4.1])
    assert [played for _, _, played in session.out] == [0, 100 * MS]
    assert session.ends == [None]


def test_what_is_told_to_start_paused_waits_for_nothing_else():
    session = Session(Tape([0, 100 * MS]), start_paused=True)
    ready = Ready(session, after=3)
    session.player.run(ready)
    assert (ready.asked, session.out) == ([], [])


@pytest.mark.parametrize(("action", "played"), [("pause", 0), ("resume", 2), ("toggle", 2), ("stop", 0)])
def test_a_command_ends_the_wait(action, played):
    session = Session(Tape([0, 100 * MS]))
    ready = Ready(session, after=100, action=lambda player: getattr(player, action)())
    session.player.run(ready)
    assert len(ready.asked) == 2
    assert len(session.out) == played


times = st.lists(st.integers(0, 20_000 * MS), min_size=1, max_size=30).map(sorted)
rates = st.floats(0.01, 100.0)


@given(times=times, rate=rates)
def test_every_message_leaves_once_at_its_time(times, rate):
    session = Session(Tape(times), rate=rate).run()
    assert session.times == times
    assert [now for now, _, _ in session.out] == pytest.approx([time * 1e-9 / rate for time in times], abs=1e-6)
    assert [played for _, _, played in session.out] == times
    assert (session.ends, session.moves) == ([None], [(START, 0)])
    assert session.player.punctuality.messages == len(times)
    assert session.player.punctuality.worst < 1e-6
    assert session.clock.time - 17.0 == pytest.approx((max(times) + 50 * MS) * 1e-9 / rate, abs=1e-6)


moments = st.floats(0.0, 30.0)
commands = st.lists(
    st.one_of(
        st.tuples(moments, st.just("pause"), st.none()),
        st.tuples(moments, st.just("resume"), st.none()),
        st.tuples(moments, st.just("toggle"), st.none()),
        st.tuples(moments, st.just("set_rate"), st.floats(0.1, 20.0)),
        st.tuples(moments, st.just("seek"), st.floats(0.0, 1.0)),
    ),
    max_size=8,
    unique_by=lambda command: command[0],
)


@given(times=times, rate=st.floats(0.1, 20.0), commands=commands)
def test_what_has_been_played_is_the_rate_over_the_time_in_which_it_ran(times, rate, commands):
    """An independent sum over the commands says when each message is due, and which comes after a seek."""
    tape = Tape(times)
    done, sought = [], []

    def act(name, value):
        def action(player):
            done.append((session.clock.time - 17.0, name, value))
            if name == "seek":
                value_ns = START + round(value * (tape.end_ns - START - 1))
                sought.append((len(session.out), value_ns))
                player.seek(value_ns)
            else:
                getattr(player, name)(*(() if value is None else (value,)))

        return action

    session = Session(tape, [(at, act(name, value)) for at, name, value in commands], rate=rate)
    session.run()

    def played_until(now):
        total, since, speed, running = 0.0, 0.0, rate, True
        for at, name, value in done:
            if at >= now:
                break
            total, since = total + (at - since) * speed * running, at
            running = {"pause": False, "resume": True, "toggle": not running}.get(name, running)
            speed = value if name == "set_rate" else speed
        return total + (now - since) * speed * running

    for now, _, played in session.out:
        assert played * 1e-9 == pytest.approx(played_until(now), abs=1e-5)
    assert all(before <= after for (_, _, before), (_, _, after) in pairwise(session.out))
    for count, value_ns in dict(sought).items():  # of those between two messages the last
        if count < len(session.out):
            assert session.times[count] == min(time for time in times if START + time >= value_ns)
    lead = {played - item.time_ns for _, item, played in session.out}
    assert len(lead) <= 1 + len(sought)


@given(times=times, offset=st.floats(0.0, 1.0), length=st.floats(0.0, 1.0))
def test_part_of_a_bag(times, offset, length):
    tape = Tape(times)
    whole = (tape.end_ns - START) * 1e-9
    offset, length = offset * whole * 0.99, length * whole
    session = Session(tape, start_offset=offset, duration=length).run()
    first = round(offset * 1e9)
    last = first + round(length * 1e9) if round(length * 1e9) else tape.end_ns - START
    assert session.times == [time for time in times if first <= time < last]
    assert [played for _, _, played in session.out] == [time - first for time in session.times]


@given(times=times, rounds=st.integers(2, 5), rate=rates)
def test_loop_goes_on_without_a_gap_and_without_a_leap(times, rounds, rate):
    tape = Tape(times)
    wanted = rounds * len(times)
    session = Session(tape, loop=True, rate=rate)
    deliver = session.player._deliver

    def stop_at_the_end(item, played):
        deliver(item, played)
        if len(session.out) == wanted:
            session.player.stop()

    session.player._deliver = stop_at_the_end
    session.run()
    length = tape.end_ns - START
    expected = [number * length + time for number in range(rounds) for time in times]
    assert [played for _, _, played in session.out] == expected
    assert [now for now, _, _ in session.out] == pytest.approx([time * 1e-9 / rate for time in expected], abs=1e-5)
    assert session.moves == [(START, number * length) for number in range(rounds)]
    assert session.ends == []


def test_loop_that_holds_nothing_ends():
    tape = Tape([0, 1000 * MS])
    assert Session(tape, loop=True, start_offset=0.5, duration=0.2).run().ends == [None]


def test_as_fast_as_possible_takes_no_time():
    session = Session(Tape([0, 10**9, 10**12]), rate=0.0).run()
    assert (len(session.out), session.clock.time) == (3, 17.0)


def test_steps_play_whole_chunks_and_the_clock_stands():
    answers = []
    tape = Tape(range(0, 600 * MS, 50 * MS), every=3)
    script = [
        (1.0, lambda player: answers.append(player.step())),
        (2.0, lambda player: answers.append(player.step(2))),
        (3.0, lambda player: answers.append(player.burst(1))),
        (4.0, lambda player: answers.append(player.step(9))),
        (5.0, lambda player: answers.append(player.step())),
        (6.0, lambda player: player.resume()),
    ]
    session = Session(tape, script, start_paused=True).run()
    assert [answer.result() for answer in answers] == [1, 2, 1, 1, 0]
    # What is left of a chunk is played with the step that follows.
    assert [now for now, _, _ in session.out] == [1.0] * 3 + [2.0] * 6 + [3.0] + [4.0] * 2
    assert session.times == [*range(0, 600 * MS, 50 * MS)]
    assert session.ends == [None]


def test_goes_on_from_where_it_stepped():
    tape = Tape([0, 100 * MS, 200 * MS, 300 * MS])
    script = [(1.0, lambda player: player.step(2)), (5.0, lambda player: player.resume())]
    session = Session(tape, script, start_paused=True).run()
    assert [now for now, _, _ in session.out] == pytest.approx([1.0, 1.0, 5.0, 5.1])


def test_a_paused_replay_is_there_at_its_end_and_can_be_sent_back():
    tape = Tape([0, 100 * MS])
    script = [
        (1.0, lambda player: player.burst()),
        (2.0, lambda player: player.restart()),
        (3.0, lambda player: player.resume()),
    ]
    session = Session(tape, script, start_paused=True).run()
    assert [now for now, _, _ in session.out] == pytest.approx([1.0, 1.0, 3.0, 3.1])
    assert session.moves == [(START, 0), (START, 150 * MS)]


def test_steps_of_a_loop_begin_again():
    tape = Tape([0, 100 * MS])
    script = [(1.0, lambda player: player.step(3))]
    session = Session(tape, script, start_paused=True, loop=True).run()
    assert session.times == [0, 100 * MS, 0]
    assert [played for _, _, played in session.out] == [0, 100 * MS, 150 * MS]


def test_a_seek_while_paused_stays_paused_there():
    tape = Tape([0, 100 * MS, 200 * MS])
    where = []
    script = [
        (0.05, lambda player: player.pause()),
        (1.0, lambda player: player.seek(START + 150 * MS)),
        (2.0, lambda player: where.append((player.paused, player.position_ns - START))),
        (3.0, lambda player: player.resume()),
    ]
    session = Session(tape, script).run()
    assert where == [(True, 150 * MS)]
    assert [now for now, _, _ in session.out] == pytest.approx([0.0, 3.05])


def test_steps_of_a_running_replay_are_refused():
    asked = []
    Session(Tape([0, 10**9]), [(0.5, lambda player: asked.append(player.step()))]).run()
    with pytest.raises(InputError, match="pause it first"):
        asked[0].result()


def test_what_comes_too_late_is_refused():
    session = Session(Tape([0])).run()
    with pytest.raises(InputError, match="the replay is over"):
        session.player.pause().result()


@pytest.mark.parametrize("seconds", [-0.001, 1.05, 1e9])
def test_seek_beyond_the_bag_is_refused_with_its_range(seconds):
    player = Session(Tape([0, 10**9])).player
    with pytest.raises(InputError, match=r"^position = .* give a time from 0 s to before 1\.05 s$"):
        player.seek(START + round(seconds * 1e9))


@pytest.mark.parametrize("rate", [-1.0, 1001.0, float("nan"), float("inf")])
def test_rate_out_of_range_is_refused(rate):
    with pytest.raises(InputError, match=r"^rate = .* from 0 to 1000"):
        Session(Tape([0])).player.set_rate(rate)


def test_offset_behind_the_end_is_refused():
    with pytest.raises(
        InputError, match=r"^start_offset = 2 s is after the end of the bag: give a time below 1\.05 s$"
    ):
        Session(Tape([0, 10**9]), start_offset=2.0)


def test_what_fails_ends_the_replay_with_the_reason():
    session = Session(Tape([0, 10**9]))
    session.player._deliver = lambda item, played: 1 / 0
    session.run()
    assert [type(end) for end in session.ends] == [ZeroDivisionError]


@pytest.mark.slow
def test_commands_from_other_threads_are_done_in_their_order():
    """The real clock, a real thread: a player that never waits is told hundreds of things by two others."""
    tape = Tape(range(0, 1000 * MS, MS))
    ends = []
    out = []
    player = Player(
        tape,
        Playback(rate=0.0, loop=True),
        lambda item, played: out.append(played),
        lambda begin, played: None,
        ends.append,
    )
    playing = threading.Thread(target=player.run)
    playing.start()

    def disturb():
        for number in range(100):
            player.seek(START + number * MS).result(60)
            player.set_rate(0.0).result(60)

    others = [threading.Thread(target=disturb) for _ in range(2)]
    for other in others:
        other.start()
    for other in others:
        other.join()
    player.pause().result(60)
    count = len(out)
    assert player.step(5).result(60) == 5
    assert len(out) == count + 5
    player.stop()
    playing.join(60)
    assert not playing.is_alive()
    assert out == sorted(out)
    assert ends == []
