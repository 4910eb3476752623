"""How times are taken and what becomes of them."""

from drivegate_lab.bench.workbench import Correctness, Value, duration, interleaved, rate, ratio, timed

RIGHT = Correctness(True, "right")


class Clock:
    """A clock that only work moves."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def works(self, seconds):
        def work() -> None:
            self.now += seconds

        return work


def test_the_time_of_one_piece_of_work_is_reported_whatever_its_length():
    for seconds in (1e-4, 3.0):
        clock = Clock()
        times = timed(clock.works(seconds), clock, 4)
        assert len(times) == 4
        assert all(abs(time - seconds) < 1e-9 for time in times), times


def test_short_work_is_repeated_within_a_round():
    clock, calls = Clock(), []
    work = clock.works(1e-3)
    timed(lambda: calls.append(work()), clock, 2)
    assert len(calls) == 1 + 2 * 20, "20 ms a round, after a first call that states how long one takes"


def test_works_take_turns():
    clock, order = Clock(), []
    works = tuple(_named(order, clock, name) for name in "ab")
    interleaved(works, clock, 3)
    assert "".join(order) == "ab" + "ababab"


def _named(order, clock, name):
    step = clock.works(1.0)

    def work() -> None:
        order.append(name)
        step()

    return work


def test_the_best_round_counts_and_the_median_is_kept():
    assert rate(10.0, [2.0, 5.0, 4.0], RIGHT) == Value(5.0, 2.5, 3, RIGHT)
    assert duration([2.0, 5.0, 4.0], RIGHT, 1e3) == Value(2000.0, 4000.0, 3, RIGHT)


def test_times_in_turns_are_set_against_each_other_turn_by_turn():
    # The third turn was disturbed; best over best would be 1.
    assert ratio([2.0, 6.0, 1.0], [1.0, 2.0, 1.0], RIGHT) == Value(2.0, 2.0, 3, RIGHT)
