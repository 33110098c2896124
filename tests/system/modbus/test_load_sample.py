"""A short sample of the load study: what must hold on any computer."""

from studies.modbus_load import run_endurance, run_server


def rate(server: str) -> int:
    return run_server({"server": server, "clients": 16}, seconds=1.0)["requests_per_s"]


def test_our_server_answers_far_more_than_the_librarys_on_the_same_words():
    # in turn, the best of two each: something else may run on the computer for a moment
    ours, library = zip(*[(rate("ours"), rate("library")) for _ in range(2)], strict=True)
    print(f"{max(ours)} and {max(library)} requests/s")
    assert max(ours) > 1.5 * max(library)


def test_requests_and_connections_leave_no_descriptor_and_no_memory_behind():
    result = run_endurance({"clients": 16}, requests=30_000, connections=500)
    assert result["descriptors"][1] == result["descriptors"][0]
    assert result["rss_kb"][1] - result["rss_kb"][0] < 1024
