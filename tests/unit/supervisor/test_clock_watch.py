"""The wall clock that is set, and the computer that sleeps."""

from appliance.supervisor.clock_watch import SleepWatch


def test_a_sleep_shows_once_and_the_drift_of_two_readings_never():
    awake, asleep = [100.0], [0.0]
    watch = SleepWatch(lambda: awake[0] + asleep[0], lambda: awake[0])
    for _ in range(100):
        awake[0] += 0.05
        asleep[0] += 1e-5
        assert not watch.has_slept()
    asleep[0] += 2.0
    assert watch.has_slept()
    assert not watch.has_slept()
