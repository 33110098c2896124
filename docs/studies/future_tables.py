"""Tables of the studies of the dissertation's future work."""

from collections.abc import Callable

from results import Rows, Summary, length, percent, summary

HEAD = ("frames", "values", "RMSE mm", "bias mm", "worst mm", "error <= U", "median U mm")


def range_beside() -> Rows:
    """A laser beside the cameras, by rig and by what measures."""
    ways = {
        "both cameras": "cameras",
        "both and the laser": "beside",
        "left camera and the laser": "left alone",
        "right camera and the laser": "right alone",
        "both and a laser 20 mm off": "wrong",
        "left camera and a laser 20 mm off": "left alone, wrong",
    }
    found = summary("range_beside")
    rows = [
        (rig, title, *_figures(one), percent(one.get("routes_disagree", 0.0)))
        for rig in ("usual", "short")
        for title, one in ((title, found[rig][way]) for title, way in ways.items())
    ]
    return [("rig", "measured by", *HEAD, "disagree"), *rows]


def tilted_line() -> Rows:
    """Lines that rise against the boards, by tilt and by how the boards lie."""
    ways = {
        "route V, boards parallel to those seen": "parallel",
        "route V, boards turned": "turned",
        "route V, tilt fitted": "fitted",
        "route T along the line": "served",
    }
    found = summary("tilted_line")
    rows = [(tilt, title, *_figures(found[tilt][way])) for tilt in found for title, way in ways.items()]
    return [("line rises by", "", *HEAD), *rows]


def edges_learned() -> Rows:
    """The network beside the forest: what is found, what is false, where edges lie."""
    found = summary("edges_learned")
    scenes = [name for name, one in found["forest"].items() if isinstance(one, dict)]
    figures: dict[str, Callable[[Summary], str]] = {
        "rows with a false edge, %": lambda one: f"{100 * one['rows_with_a_false_edge']:.1f}",
        "limb rows within 1 px, %": lambda one: f"{100 * one['limbs_within_1_px']:.1f}",
        "width bias / spread, px": lambda one: f"{one['width_bias_px']:+.2f} / {one['spread_px']:.2f}",
    }
    rows = [
        (title, method, *(figure(found[method][scene]) for scene in scenes))
        for title, figure in figures.items()
        for method in found
    ]
    return [("", "", *scenes), *rows]


def _figures(found: Summary) -> tuple[str, ...]:
    if not found["values"]:
        return (str(found["frames"]), "0", *("-",) * (len(HEAD) - 2))
    covered = "-" if found["covered"] is None else percent(found["covered"], 1)
    return (
        *(str(found["frames"]), str(found["values"]), f"{found['rmse_mm']:.3f}"),
        f"{found['bias_mm']:+.3f} ± {found['bias_standard_error_mm']:.3f}",
        *(length(found["worst_mm"]), covered, length(found["median_expanded_mm"])),
    )


FUTURE_TABLES: dict[str, Callable[[], Rows]] = {
    "range beside": range_beside,
    "tilted line": tilted_line,
    "edges learned": edges_learned,
}
