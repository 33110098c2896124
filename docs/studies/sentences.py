"""Sentences of documents that state figures of the studies' results: `{}` stands for each number."""

from typing import Any

from results import Numbers, Sentence, result, summary
from speed_sentences import SPEED_SENTENCES
from tables import BARS

LARGE_MM = 0.4  # an error of a value that nobody should trust
LEAST_TRUST = 50  # judging.trust_min as it comes

Row = dict[str, Any]


def _whole(*shares: float) -> Numbers:
    """Shares in whole percents."""
    return tuple(f"{100 * share:.0f}" for share in shares)


def _hundredths(*values: float) -> Numbers:
    return tuple(f"{value:.2f}" for value in values)


def _served() -> Numbers:
    bars = summary("served_diameter")["bars"]
    seeds = {row["seed"] for row in result("served_diameter")["rows"]}
    covered = (f"{100 * bars[name]:.1f}" for name in ("covered", "covered_standard_error"))
    return (str(len(seeds)), f"{bars['rmse_mm']:.3f}", *covered)


def _routes() -> Numbers:
    bars = summary("served_diameter")["bars"]
    sure = [row for row in result("served_diameter")["rows"] if row["condition"] in BARS and row["valid"]]
    worst_mm = max(abs(row["error_mm"]) for row in sure if "few_windows" not in row["reasons"])
    return (*(f"{100 * bars[name]:.1f}" for name in ("calibration_due", "routes_disagree")), *_hundredths(worst_mm))


def _line() -> Numbers:
    every, told, untold = (summary("real_line")[name] for name in ("all", "ovality told", "ovality not told"))
    medians = _hundredths(told["median_expanded_mm"], untold["median_expanded_mm"])
    return (str(every["lines"]), *_whole(every["inside"]), str(every["frames"]), *medians, str(every["wrong_values"]))


def _line_wrong() -> Numbers:
    every = summary("real_line")["all"]
    return str(every["wrong_values"]), str(every["frames"])


def _line_held() -> Numbers:
    every = summary("real_line")["all"]
    shares = (every[name] for name in ("inside", "bar_inside", "inside_half", "bar_inside_half"))
    return (*_whole(*shares), str(every["wrong_values"]))


def _shimmer_of_bar() -> Numbers:
    found = summary("gauge_repeatability")["shimmer"]
    return f"{found['bar_of_tolerance_percent']:.1f}", str(found["bars"])


def _shimmer() -> Numbers:
    found = summary("gauge_repeatability")["shimmer"]
    return f"{found['of_tolerance_percent']:.0f}", f"{found['bar_of_tolerance_percent']:.1f}"


def _ingots() -> Numbers:
    first, second = (summary("ingots_elsewhere")[name]["relief"] for name in ("ingot_line", "ingot_line_b"))
    ingots, right, undecided = (first[name] + second[name] for name in ("ingots", "right", "undecided"))
    frames = (f"{100 * first['frames_right']:.0f}", f"{100 * second['frames_right']:.1f}")
    return (*frames, *map(str, (ingots, right, undecided, ingots - right - undecided)))


def _frozen() -> Numbers:
    found = summary("no_measurable_bar")["frozen"]
    return str(found["gauge_alone"]["wrong"]), str(found["frames"])


def _worth() -> Numbers:
    found = summary("worth")
    served = found["as served"]
    wrong = {name: sum(one["wrong_values"] for one in rows.values()) for name, rows in found.items()}
    kept = (wrong[name] - wrong["as served"] for name in ("without any of these checks", "without axis height"))
    others = ("without limb profile", "without contrast", "without still marks", "without agreement of the limbs")
    alone = max(wrong[name] for name in others) - wrong["as served"]
    values_mm = (
        *(served["scale"]["rmse_mm"], found["four planes"]["scale"]["rmse_mm"]),
        *(found["without still marks"]["nudged"]["rmse_mm"], served["nudged"]["rmse_mm"]),
    )
    return (
        f"{found['light not decoded']['clean']['rmse_mm']:.0f}",
        *(f"{one:.3f}" for one in values_mm),
        *map(str, (*kept, alone)),
    )


def _nudged() -> Numbers:
    large, small = (summary("nudged_camera")[degrees] for degrees in ("0.05", "0.02"))
    errors = _hundredths(*(one[name] for one in (large, small) for name in ("worst_mm", "uncorrected_worst_mm")))
    told = (large["told"], small["told"], large["cameras"])
    return (*errors, *_held(large, small), *map(str, told))


def _bars_held() -> Numbers:
    found = [summary("bars_side_by_side")[count] for count in "234"]
    return (*_held(*found), str(found[0]["pairs"]))


def _bars_and_nudged_held() -> Numbers:
    bars, cameras = summary("bars_side_by_side"), summary("nudged_camera")
    return _held(*(bars[count] for count in "234"), *(cameras[degrees] for degrees in ("0.05", "0.02")))


def _held(*groups: Row) -> Numbers:
    """Shares of values inside U and their standard errors, in percent."""
    return _whole(*(one[name] for one in groups for name in ("inside", "inside_standard_error")))


def _codings() -> Numbers:
    found = summary("camera_light")
    jpeg, h264 = found["jpeg 4:2:0 q90"], found["h264 crf 28"]
    values = (jpeg["rmse_mm"], jpeg["median_expanded_mm"], h264["rmse_mm"], h264["median_expanded_mm"])
    return (*_hundredths(*values), str(jpeg["frames"]))


def _named_responses() -> Numbers:
    found = summary("camera_light")["all"]["response"]
    counts = (str(found[name]) for name in ("wrong_responses", "wrong_responses_named"))
    return (*counts, f"{found['error_of_the_named_amount_rmse_px']:.3f}")


def _camera_light() -> Numbers:
    found = summary("camera_light")
    return str(found["rigs"]), str(found["all"]["frames"])


def _trusted_light() -> Numbers:
    rows = result("camera_light")["rows"]
    values = [one for row in rows for one in row["codings"].values() if one.get("error_mm") is not None]
    worst_mm = max(abs(one["error_mm"]) for one in values)
    large = max(one["trust"] for one in values if abs(one["error_mm"]) > LARGE_MM)
    sure = [abs(one["error_mm"]) for one in values if one["trust"] >= LEAST_TRUST]
    rmse_mm = (sum(error**2 for error in sure) / len(sure)) ** 0.5
    return (*_hundredths(worst_mm), f"{large:.0f}", str(len(sure)), *_hundredths(rmse_mm, max(sure)))


def _measured_response() -> Numbers:
    found = summary("camera_light")["all"]["response"]
    lengths = (f"{found[name]:.3f}" for name in ("half_level_rmse_px", "median_u_px"))
    return (*lengths, *_whole(found["covered"]))


def _jpeg() -> Numbers:
    found = summary("served_diameter")["jpeg 4:2:0 q90"]
    covered = (found["covered"], found["covered_standard_error"])
    return (str(found["frames"]), *_hundredths(found["rmse_mm"]), *_whole(*covered))


def _fit_of_compression() -> Numbers:
    laws = [summary("compression")[name] for name in ("jpeg", "h264")]
    return (*_hundredths(*(one for law in laws for one in law["fitted"])), *_whole(*(law["off"] for law in laws)))


def _ends_of_bars() -> Numbers:
    rows = [row for row in result("virtual_board")["rows"] if row["part"] == "corrected"]
    short = [row for row in rows if row["condition"] == "bar-end" and row["truth_mm"] is None]
    nothing = [row for row in rows if row["condition"] in {"no-bar", "one-blind", "two-bars"}]
    counts = (sum(row["valid"] for row in nothing), len(nothing), len(short), sum(row["valid"] for row in short))
    return tuple(map(str, counts))


def _best_height() -> Numbers:
    found = summary("virtual_board")["height"]
    low, high = sorted(abs(found["median_quality_by_offset"][name]) for name in ("-60 mm", "+60 mm"))
    return f"{low:.0f}", f"{high:.0f}", *_whole(found["right_sign_share"]), str(found["frames"])


def _closed_loop() -> Numbers:
    found = summary("virtual_board")["sequence"]
    return f"{100 * found['within_2_mm_in_4_boards_share']:.1f}", str(found["frames"])


def _as_printed() -> Numbers:
    missing = [1 - one["availability"] for one in summary("virtual_board")["steps"]["as printed"].values()]
    return f"{100 * min(missing):.1f}", f"{100 * max(missing):.1f}"


def _discarding() -> Numbers:
    found = summary("virtual_board")["windows"]
    names = ("median_rmse_all_mm", "median_rmse_kept_mm")
    return tuple(f"{found[condition][name]:.1f}" for name in names for condition in ("post", "glare", "scale"))


def _scale_along_an_edge() -> Numbers:
    found = summary("virtual_board")["corrected"]["scale"]
    return (*_whole(1 - found["covered"]), str(found["frames"]))


def _between_barriers() -> Numbers:
    """Lines of both studies, those of other makers, and by what is given: served, inside U, errors over 2 U."""
    own, elsewhere = (result(name)["rows"] for name in ("conveyor", "conveyor_elsewhere"))
    numbers = [str(len(own) + len(elsewhere)), str(len(elsewhere))]
    for given in ("with_heights", "barrier_height", "spacing_only"):
        readings = [row[given] for row in own + elsewhere]
        off = [abs(one["error_mm"]) / one["expanded_mm"] for one in readings if one["valid"]]
        shares = len(off) / len(readings), sum(share <= 1 for share in off) / len(off)
        numbers += [*(f"{100 * share:.1f}" for share in shares), str(sum(share > 2 for share in off))]
    return tuple(numbers)


def _no_such_line() -> Numbers:
    kinds = summary("no_such_line").values()
    values = sum(kind[shown]["values"] for kind in kinds for shown in ("itself", "striped", "elsewhere"))
    return str(len(result("no_such_line")["rows"])), str(values)


README, CAMERAS, PLC = "README.md", "docs/guides/cameras.md", "docs/guides/plc.md"
CONVEYOR, DIAMETER, REAL_LINE, UNCERTAINTY, VIRTUAL_BOARD = (
    f"docs/methods/{name}.md" for name in ("conveyor", "diameter", "real_line", "expanded_uncertainty", "virtual_board")
)
SENTENCES = (
    Sentence(
        README,
        _served,
        "Over {} rigs of the simulated mill, the ovality told as 0: RMSE {} mm, {} ± {} % of the values inside U",
    ),
    Sentence(
        README,
        _line,
        "{} lines) {} % of {} frames lie inside U, median U {} mm where the ovality is told and {} mm where it is "
        "not, and {} values are wrong.",
    ),
    Sentence(
        README,
        _shimmer_of_bar,
        "six sigma of a bar's value from eight frames are {} % of a tolerance 4 mm wide ({} bars;",
    ),
    Sentence(
        README,
        _ingots,
        "{} % of the frames of one line and {} % of the other were right; of {} ingots {} were right, {} stayed "
        "undecided, {} were wrong.",
    ),
    Sentence(
        CAMERAS,
        _codings,
        "RMSE {} mm with a median U of {} mm for JPEG of quality 90, {} mm with {} mm for H.264 of CRF 28, {} rigs "
        "each",
    ),
    Sentence(
        DIAMETER,
        _camera_light,
        "{} rigs with a response of random shape that nobody tells, measured from 16 boards in the same coding; bars "
        "clean, with scale or over lit rollers, each as PNG and in one group of codings. {} values in all",
    ),
    Sentence(
        DIAMETER,
        _trusted_light,
        "Patches of scale and compression together leave errors of up to {} mm, not always within U; every value that "
        "is off by more than 0.4 mm has a trust of at most {} %. The {} values with a trust of 50 % or more have an "
        "RMSE of {} mm, the worst is {} mm off.",
    ),
    Sentence(
        DIAMETER,
        _measured_response,
        "The measured response moves half level of a bar's edge (0.8 px of blur, light 0.02 to 0.9) by {} px RMS, "
        "stated u {} px; {} % of these moves are within 2 u.",
    ),
    Sentence(
        DIAMETER,
        _named_responses,
        "Of the names that a `board.json` might tell, {} would have moved an edge by more than 0.1 px, and {} of these "
        "were named, by how much to {} px RMS.",
    ),
    Sentence(
        CAMERAS,
        _jpeg,
        "Over {} rigs whose response is told, JPEG 4:2:0 of quality 90 gives an RMSE of {} mm and {} ± {} % inside U",
    ),
    Sentence(
        PLC,
        _bars_held,
        "of two, three and four bars {} ± {}, {} ± {} and {} ± {} % of the values lay inside U ({} rigs;",
    ),
    Sentence(
        DIAMETER,
        _routes,
        "`calibration_due` came with {} % of these values, `routes_disagree` with {} %. The largest error without "
        "`few_windows` is {} mm.",
    ),
    Sentence(DIAMETER, _frozen, "the gauge alone would have given {} wrong values of {}."),
    Sentence(
        DIAMETER,
        _worth,
        "Decoding the light is worth most, {} mm. One cylinder takes {} mm where four planes take {} on limbs that "
        "scale covers. Still marks, by which a turned camera is turned back, take a nudge from {} to {} mm. "
        "Together the checks keep {} of these frames from a wrong value; the axis' height alone keeps {}, each of "
        "the others alone at most {}.",
    ),
    Sentence(
        UNCERTAINTY,
        _line_held,
        "{} % of single frames and {} % of bars' values inside U, {} and {} % inside half of it, {} wrong values.",
    ),
    Sentence(
        UNCERTAINTY,
        _bars_and_nudged_held,
        "Of two, three and four bars side by side {} ± {}, {} ± {} and {} ± {} % of the values lie inside U, after "
        "turns of a camera by 0.05 and 0.02 degrees {} ± {} and {} ± {} %",
    ),
    Sentence(
        CONVEYOR,
        _between_barriers,
        "Over all {} lines, {} of them of other makers, {} % got a value with both heights given, {} % of these "
        "inside U, {} off by more than 2 U; with W and the barriers' height {} %, {} % and {}; with W alone {} %, "
        "{} % and {}.",
    ),
    Sentence(CONVEYOR, _no_such_line, "{} pictures that show no line between barriers gave {} values"),
    Sentence(REAL_LINE, _line_wrong, "Wrong values: {} of {}."),
    Sentence(
        REAL_LINE,
        _shimmer,
        "6 sigma of single frames are {} % of a tolerance 4 mm wide, of bars of eight frames {} %.",
    ),
    Sentence(
        REAL_LINE,
        _nudged,
        "turned by 0.05 degrees the error is at most {} mm ({} uncorrected), by 0.02 degrees {} mm ({}); {} ± {} and "
        "{} ± {} % of the values lie inside U. `calibration_due` came for {} and {} of {}: a turn about the camera's "
        "own axis moves marks by less than 0.3 px",
    ),
    Sentence(VIRTUAL_BOARD, _as_printed, "As printed, {} to {} % of the frames got no value."),
    Sentence(
        VIRTUAL_BOARD,
        _ends_of_bars,
        "{} values came from {} frames without a bar, with two bars or with a blind camera. Of {} bars' ends that "
        "cover less than half of the region {} got a value.",
    ),
    Sentence(
        VIRTUAL_BOARD,
        _best_height,
        "60 mm off leaves {} to {} % of the overlap, and the sign told the direction in {} % of {} frames.",
    ),
    Sentence(
        VIRTUAL_BOARD,
        _closed_loop,
        "The loop ended within 2 mm of a search over 321 boards, after at most four boards, in {} % of {} frames",
    ),
    Sentence(
        VIRTUAL_BOARD,
        _discarding,
        "median RMSE of the windows behind a post {} mm, at glare {}, with scale {} before; {}, {} and {} after",
    ),
    Sentence(
        VIRTUAL_BOARD,
        _scale_along_an_edge,
        "Scale along a whole edge moves it inwards by up to a pixel; U did not cover {} % of {} such frames",
    ),
    Sentence(
        "vision/compression.py",
        _fit_of_compression,
        "the study fits {}, {}, {} and {}, {}, {}. Shares scatter about the constants below by {} and {} %",
    ),
    *SPEED_SENTENCES,
)
