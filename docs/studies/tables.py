"""Tables of the studies' results, by the name in the line `<!-- table: NAME -->` that stands before each."""

from collections.abc import Callable

from camera_tables import CAMERA_TABLES
from edge_tables import EDGE_TABLES
from future_tables import FUTURE_TABLES
from results import Rows, Summary, length, lengths, percent, summary


def served_diameter(groups: dict[str, str]) -> Rows:
    """The diameter as served, a row for each condition, by the name of its group in the summary."""
    head = (
        *("condition", "frames with a measurable bar", "that got a value", "RMSE mm", "worst mm", "bias mm"),
        *("error <= U", "error <= U / 2", "median U mm", "wrong values", "route V: RMSE, worst mm"),
    )
    return [head, *(_served_row(title, summary("served_diameter")[name]) for title, name in groups.items())]


def _served_row(title: str, found: Summary) -> tuple[str, ...]:
    return (
        *(title, str(found["frames"]), percent(found["availability"], 1)),
        "{:.3f} ({:.3f} to {:.3f})".format(found["rmse_mm"], *found["rmse_95_mm"]),
        length(found["worst_mm"]),
        f"{found['bias_mm']:+.3f} ± {found['bias_standard_error_mm']:.3f}",
        _covered(found),
        percent(found["covered_by_half_of_it"], 1),
        length(found["median_expanded_mm"]),
        str(found["wrong_values"]),
        lengths(found, "virtual_board_rmse_mm", "virtual_board_worst_mm"),
    )


def _covered(found: Summary) -> str:
    return f"{100 * found['covered']:.1f} ± {100 * found['covered_standard_error']:.1f} %"


def expanded_uncertainty() -> Rows:
    """How often U held, of the served diameter."""
    groups = {"bars as they are": "bars", "with one effect": "effects"} | {f"of it {name}": name for name in EFFECTS}
    found = {title: summary("served_diameter")[name] for title, name in groups.items()}
    rows = [
        (
            *(title, str(one["frames"]), _covered(one), percent(one["covered_by_half_of_it"], 1)),
            *(f"{length(one[name])} mm" for name in ("median_expanded_mm", "worst_mm")),
        )
        for title, one in found.items()
    ]
    return [("", "frames", "error <= U", "error <= U / 2", "median U", "worst error"), *rows]


def camera_light() -> Rows:
    """Pictures as cameras send them."""
    head = (
        *("coding", "values", "bias, RMSE", "from PNG", "route V", "inside U, median U"),
        *("before: bias, RMSE", "before: inside U"),
    )
    found = summary("camera_light")
    codings = {name: one for name, one in found.items() if isinstance(one, dict) and name not in BARS}
    return [head, *(_coding_row("**all**" if name == "all" else name, found) for name, found in codings.items())]


def _coding_row(title: str, found: Summary) -> tuple[str, ...]:
    before = found["before"]
    return (
        *(title, str(found["frames"]), f"{found['bias_mm']:+.2f}, {found['rmse_mm']:.2f}"),
        f"{found['from_png_mean_mm']:+.2f}, {found['from_png_rms_mm']:.2f}",
        f"{found['virtual_board_bias_mm']:+.2f}, {found['virtual_board_rmse_mm']:.2f}",
        f"{percent(found['covered'])}, {length(found['median_expanded_mm'])}",
        f"{before['bias_mm']:+.2f}, {before['rmse_mm']:.2f}",
        percent(before["covered"]),
    )


def gauge_repeatability() -> Rows:
    """The same bar at the same place."""
    head = (
        *("", "bars", "standard deviation mm", "worst bar mm", "6 sigma of 4 mm"),
        *("bar's value: standard deviation mm, 6 sigma of 4 mm", "`u_edge_mm`", "route V, standard deviation mm"),
    )
    rows = [
        (
            *(name, str(found["bars"]), *(length(found[one], ".4f") for one in ("sigma_mm", "worst_sigma_mm"))),
            f"{found['of_tolerance_percent']:.1f} % (worst {found['worst_of_tolerance_percent']:.1f} %)",
            f"{found['sigma_bar_mm']:.4f}, {found['bar_of_tolerance_percent']:.1f} %",
            *(length(found[one], ".4f") for one in ("u_edge_mm", "sigma_virtual_board_mm")),
        )
        for name, found in summary("gauge_repeatability").items()
    ]
    return [head, *rows]


def rendered_boards() -> Rows:
    """A rig calibrated from pictures beside one from projected corners."""
    head = (
        *("", "rigs", "from pictures: RMSE, worst mm", "from projected corners: RMSE, worst mm"),
        *("difference: RMS, worst mm", "difference over its u, RMS"),
    )
    rows = [
        (
            *(name, str(found["rigs"])),
            *(f"{found[f'rmse_mm_{kind}']:.3f}, {found[f'worst_mm_{kind}']:.2f}" for kind in ("rendered", "projected")),
            lengths(found, "rms_difference_mm", "worst_difference_mm", form=".3f"),
            length(found["rms_difference_over_u"]),
        )
        for name, found in summary("rendered_boards").items()
    ]
    return [head, *rows]


def no_measurable_bar() -> Rows:
    """Frames without a measurable bar, with up to four reasons of those that had no value."""
    head = ("pictures", "frames", "no value", "right value", "wrong value", "why there was none, the most frequent")
    return [head, *(_no_bar_row(name, found) for name, found in summary("no_measurable_bar").items())]


def _no_bar_row(name: str, found: Summary) -> tuple[str, ...]:
    reasons: dict[str, int] = found.get("without_a_value_because", {})
    frequent = sorted(reasons, key=lambda reason: (-reasons[reason], reason))[:4]
    return (
        *("**all**" if name == "all" else name, str(found["frames"])),
        f"{found['no_value']} ({percent(found['no_value'] / found['frames'])})",
        *(str(found[one]) for one in ("right_values", "wrong_values")),
        "" if name == "all" else ", ".join(f"`{reason}` {reasons[reason]}" for reason in frequent),
    )


def worth() -> Rows:
    """Errors with a step or check left out."""
    shown = ("clean", "scale", "post", "glare", "bounce", "nudged", "smoothed by the camera")
    rows = [(name, *(_worth_cell(found[one]) for one in shown)) for name, found in summary("worth").items()]
    return [("RMSE (worst) mm", *shown), *rows]


def _worth_cell(found: Summary) -> str:
    missing = found["frames"] - found["values"]
    text = f"{found['rmse_mm']:.3f} ({found['worst_mm']:.2f})"
    return text + (f", {missing} without a value" if missing else "")


def worth_of_checks() -> Rows:
    """Values and wrong values of frames without a measurable bar, with a step or check left out."""
    shown = [name for name in summary("no_measurable_bar") if name != "all"]
    rows = [
        (
            name,
            *(f"{found[one]['values']}, {found[one]['wrong_values']}" for one in shown),
            str(sum(found[one]["wrong_values"] for one in shown)),
        )
        for name, found in summary("worth").items()
    ]
    return [("values, of them wrong", *shown, "wrong in all"), *rows]


def real_line() -> Rows:
    """Lines with everything at once, and by effect."""
    head = (
        *("lines", "number", "served", "RMSE, worst mm", "inside U", "inside U / 2", "median U mm"),
        *("bar: RMSE, worst mm", "bar: inside U, U / 2", "bar: median U mm"),
    )
    first = ("all", "ovality told", "ovality not told", "none", "several")
    found = {name: one for name, one in summary("real_line").items() if isinstance(one, dict)}
    order = [*first, *(name for ending in (" alone", "with ") for name in found if ending in name)]
    return [head, *(_line_row("**all**" if name == "all" else name, found[name]) for name in order)]


def _line_row(title: str, found: Summary) -> tuple[str, ...]:
    return (
        *(title, str(found["lines"]), percent(found["served"]), lengths(found, "rmse_mm", "worst_mm")),
        *(percent(found[name]) for name in ("inside", "inside_half")),
        *(length(found["median_expanded_mm"]), lengths(found, "bar_rmse_mm", "bar_worst_mm")),
        ", ".join(percent(found[name]) for name in ("bar_inside", "bar_inside_half")),
        length(found["bar_median_expanded_mm"]),
    )


def bars_side_by_side() -> Rows:
    """Several bars in one pair of pictures."""
    rows = [
        (
            *(count, f"{found['values']} of {found['bars']}", str(found["false_values"])),
            *(lengths(found, "rmse_mm", "worst_mm"), length(found["median_expanded_mm"])),
            f"{100 * found['inside']:.0f} ± {100 * found['inside_standard_error']:.0f} %",
        )
        for count, found in summary("bars_side_by_side").items()
    ]
    return [("bars", "values", "false values", "RMSE, worst mm", "median U mm", "inside U"), *rows]


def conveyor() -> Rows:
    """One camera between barriers, by how it looks and what is given."""
    looks = {
        "line": "along the line",
        "aside": "up to 5 degrees across it",
        "assumed": "anything that is assumed",
    }
    given = {
        "with_heights": "W, barriers' height, camera's height",
        "barrier_height": "W, barriers' height",
        "spacing_only": "W alone",
    }
    found = summary("conveyor")
    rows = [_conveyor_row(looks[a], given[b], found[a][b]) for a in looks for b in given]
    return [("the camera looks", *CONVEYOR_HEAD), *rows]


CONVEYOR_HEAD = (
    *("given", "got a value", "RMSE mm", "bias mm", "worst mm"),
    *("error <= U", "median U mm", "errors over 2 U"),
)


def _conveyor_row(line: str, given: str, found: Summary) -> tuple[str, ...]:
    bias = f"{found['bias_mm']:+.2f} ± {found['bias_standard_error_mm']:.2f}"
    return (
        *(line, given, f"{found['valid']} of {found['lines']}", length(found["rmse_mm"]), bias),
        *(length(found["worst_mm"]), percent(found["inside"], 1)),
        *(length(found["median_expanded_mm"]), str(found["errors_over_twice_expanded"])),
    )


def conveyor_elsewhere() -> Rows:
    """Lines between barriers of other makers."""
    lines = {
        "rollers": "over rollers, standing or hanging",
        "plain": "hanging over a plain floor",
        "faces": "faces of any light",
    }
    given = {
        "lower_edge_given": "W, both heights, lower edge, response",
        "with_heights": "W, both heights, response",
        "barrier_height": "W, barriers' height, response",
        "barrier_height_without_an_empty_picture": "the same, no empty picture",
        "spacing_only": "W, response",
        "barrier_height_response_not_given": "W, barriers' height; response not given",
    }
    found = summary("conveyor_elsewhere")
    rows = [_conveyor_row(lines[a], given[b], found[a][b]) for a in lines for b in given]
    return [("barriers", *CONVEYOR_HEAD), *rows]


def virtual_board() -> Rows:
    """Route V as served, by condition."""
    found = summary("virtual_board")
    shown = {name: one for name, one in found["corrected"].items() if one["frames"]}
    shown["one camera at each side, unequal heights: clean"] = found["unequal"]["clean"]
    shown["the same: scale"] = found["unequal"]["scale"]
    rows = [
        (
            *(name, str(one["frames"]), percent(one["availability"]), length(one["rmse_mm"], ".3f")),
            *(length(one["worst_mm"]), f"{one['bias_mm']:+.3f} ± {one['bias_standard_error_mm']:.3f}"),
            percent(one["covered"]),
        )
        for name, one in shown.items()
    ]
    head = ("condition", "frames with a measurable bar", "that got a value", "RMSE mm", "worst mm", "bias mm")
    return [(*head, "error <= U"), *rows]


def virtual_board_steps() -> Rows:
    """Route V as printed, and with one correction after the other."""
    titles = {
        "+ robust lines": "+ one robust line for each edge",
        "+ tangent crossing": "+ tangent crossing, both views",
    }
    found = summary("virtual_board")["steps"]
    shown = list(found["as printed"])
    rows = [
        (
            titles.get(str(name), str(name)),
            *(f"{_short(one[kind]['rmse_mm'])} ({_short(one[kind]['worst_mm'])})" for kind in shown),
        )
        for name, one in found.items()
    ]
    return [("route", *shown), *rows]


def _short(value_mm: float) -> str:
    return f"{value_mm:.1f}" if value_mm >= 10 else f"{value_mm:.3f}"


def route_v_uncertainty() -> Rows:
    """U of route V with every edge detector."""
    rows = [
        (
            *(name, f"{found['values']} of {found['frames']}", percent(found["covered"])),
            *(length(found[one]) for one in ("rmse_mm", "median_expanded_mm", "rms_from_forest_mm")),
            percent(found["most_from_forest_of_u"]),
        )
        for name, found in summary("route_v_uncertainty").items()
    ]
    columns = ("error within U", "RMSE mm", "median U mm", "from the forest's, RMS mm", "at most, of U")
    return [("edges", "values", *columns), *rows]


def ingots_elsewhere() -> Rows:
    """Ends of ingots of several mills by every classifier."""
    shown = ("relief", "wrinkles", "dual", "single")
    found = summary("ingots_elsewhere")
    rows = [
        (f"{line}, {one['relief']['ingots']} ingots", *(_classifier_cell(one[name]) for name in shown))
        for line, one in found.items()
    ]
    return [("line", *(f"`{name}`" for name in shown)), *rows]


def _classifier_cell(found: Summary) -> str:
    counts = (found[name] for name in ("right", "undecided", "tops_called_bottom", "false_alarms"))
    return f"{percent(found['frames_right'], 1)}, {'/'.join(map(str, counts))}"


def ingots_evidence() -> Rows:
    """Evidence of a frame by every classifier: how far its log odds hold, and how much two frames of an ingot share."""
    found = summary("ingots_elsewhere")["all simulated"]
    rows = [
        (
            *(f"`{name}`", percent(1 - one["frames_right"], 1), percent(one["frames_wrong_expected"], 1)),
            f"{one['correlation']:.2f}",
        )
        for name, one in ((name, found[name]) for name in ("relief", "wrinkles", "dual", "single"))
    ]
    return [("classifier", "frames wrong", "as its log odds say", "correlation of an ingot's frames"), *rows]


def ingots() -> Rows:
    """Ingots under each condition of the simulated line, and of path-traced sequences, by the served classifier."""
    rows: Rows = [
        (
            *(name, str(one["sequences"]), _ends_cell(one)),
            _share(one["relief"]["accuracy"]) if "relief" in one else "-",
            "/".join(str(one[kind]) for kind in ("right", "undecided", "wrong")),
            f"{one['false_alarms']}, {one['decisions_without_an_ingot']}",
        )
        for name, one in summary("ingots").items()
    ]
    head = ("condition", "sequences", "placed frames, ends found", "frames right", "ingots right/undecided/wrong")
    return [(*head, "false alarms, decisions without an ingot"), *rows]


def _ends_cell(found: Summary) -> str:
    return f"{found['placed_frames']:,}, {_share(found['ends_found'])}" if found["placed_frames"] else "0"


def references_over_weeks() -> Rows:
    """References that learn over fifty weeks: percent of the pictures that are right, before and after a new camera."""
    rows = [
        (
            *(kind, str(found["none"]["lines"])),
            *(f"{one['before_the_new_camera']:.1f}, {one['with_the_new_camera']:.1f}" for one in found.values()),
            f"{min(one['least_gain'] for one in found.values()):.1f}",
        )
        for kind, found in summary("references_over_weeks").items()
    ]
    ways = ("as commissioned", "by agreement", "by an operator", "by one who is wrong once in 20 times")
    return [("ends, classifier", "lines", *ways, "least gain of a line"), *rows]


def _share(share: float) -> str:
    return percent(share, 0 if share == 1 else 1)


BARS = ("clean", "scale", "post", "glare", "overexposed", "bar-end", "rollers", "haze")
EFFECTS = ("ovality", "camber", "shimmer", "bounce", "nudged", "jpeg 4:2:0 q90")
TABLES: dict[str, Callable[[], Rows]] = {
    "served diameter, bars": lambda: served_diameter({"**all of these**": "bars"} | {name: name for name in BARS}),
    "served diameter, effects": lambda: served_diameter(
        {"**all of these**": "effects"} | {name: name for name in EFFECTS}
    ),
    "expanded uncertainty": expanded_uncertainty,
    "camera light": camera_light,
    "gauge repeatability": gauge_repeatability,
    "rendered boards": rendered_boards,
    "no measurable bar": no_measurable_bar,
    "worth": worth,
    "worth of checks": worth_of_checks,
    "real line": real_line,
    "bars side by side": bars_side_by_side,
    "conveyor": conveyor,
    "conveyor elsewhere": conveyor_elsewhere,
    "virtual board": virtual_board,
    "virtual board, steps": virtual_board_steps,
    "route V uncertainty": route_v_uncertainty,
    "ingots elsewhere": ingots_elsewhere,
    "ingots evidence": ingots_evidence,
    "ingots": ingots,
    "references over weeks": references_over_weeks,
    **CAMERA_TABLES,
    **EDGE_TABLES,
    **FUTURE_TABLES,
}
