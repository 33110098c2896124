"""Tables of the studies of edges and of fusion, in the order of the documents."""

from collections.abc import Callable
from math import sqrt
from statistics import mean, stdev

from results import Rows, Summary, length, lengths, summary

CONDITIONS = ("clean", "scale", "post", "haze")
EDGE_SCENES = ("clean", "rollers", "haze", "overexposed", "dim", "scale", "line_a clean", "line_a scale")
OWN_METHODS = ("fft", "db2", "db4", "db8", "db16", "fk4", "fk6", "fk8", "fk18")  # the dissertation's nine
WITH_FOREST = ("none", "left", "right", "fft", "db4", "db16", "fk4", "pyramid", "average", "maximum")
METRICS = {"H": ".3f", "SD": ".3f", "SF": ".3f", "AG": ".3f", "FMI": ".4f", "SCD": ".4f", "ESSIM": ".4f"}


def _by_condition(study: str, title: str, cell: Callable[[Summary], str], *, without: tuple[str, ...] = ()) -> Rows:
    found = summary(study)
    names = [name for name in found["clean"] if name not in without]
    return [(title, *CONDITIONS), *((name, *(cell(found[one][name]) for one in CONDITIONS)) for name in names)]


def fusion_errors() -> Rows:
    """Route V on one picture out of two: errors."""
    return _by_condition("fusion", "error, mm: median (RMSE, worst)", _fusion_error)


def _fusion_error(found: Summary) -> str:
    return f"{length(found['median_abs_mm'])} ({length(found['rmse_mm'])}, {length(found['worst_mm'], '.1f')})"


def fusion_windows() -> Rows:
    """Route V on one picture out of two: windows that were sized."""
    return _by_condition("fusion", "windows sized, %", lambda found: f"{100 * found['sized']:.0f}")


def fusion_false_edges() -> Rows:
    """False edges and kept ones, by method."""
    title = "false edges a row (edge kept, % of rows)"
    return _by_condition("fusion", title, _false_edges, without=("none",))


def _false_edges(found: Summary) -> str:
    return f"{found['false_edges']:.2f} ({100 * found['edges_kept']:.0f})"


def fusion_forest() -> Rows:
    """The same with the forest's edges."""
    title = "forest: windows sized %, false edges a row, RMSE mm"
    others = tuple(name for name in summary("fusion_forest")["clean"] if name not in WITH_FOREST)
    return _by_condition("fusion_forest", title, _with_forest, without=others)


def _with_forest(found: Summary) -> str:
    return f"{100 * found['sized']:.0f}, {lengths(found, 'false_edges', 'rmse_mm')}"


def fusion_metrics() -> Rows:
    """Metrics of fused pictures, the best of the dissertation's methods in bold."""
    found = summary("fusion_pictures")
    best = {
        name: (min if name == "ESSIM" else max)(OWN_METHODS, key=lambda method, name=name: found[method][name])
        for name in METRICS
    }
    rows = [
        (method, *(_metric(one.get(name), form, bold=best[name] == method) for name, form in METRICS.items()))
        for method, one in found.items()
    ]
    return [("", *METRICS), *rows]


def _metric(value: float | None, form: str, *, bold: bool) -> str:
    return f"**{length(value, form)}**" if bold else length(value, form)


def _by_method(cell: Callable[[Summary], str]) -> Rows:
    found = summary("edges")["colour"]
    return [
        ("method", *EDGE_SCENES),
        *((name, *(cell(one[scene]) for scene in EDGE_SCENES)) for name, one in found.items()),
    ]


def edges_false() -> Rows:
    """Rows with a false edge, and each method's threshold."""
    head, *rows = _by_method(lambda found: f"{100 * found['rows_with_a_false_edge']:.1f}")
    found = summary("edges")["colour"]
    return [
        ("method", "threshold", *head[1:]),
        *((name, f"{found[name]['threshold']:.3f}", *cells) for name, *cells in rows),
    ]


def edges_found() -> Rows:
    """Limb rows with an edge near the limb."""
    return _by_method(lambda found: f"{100 * found['limbs_within_1_px']:.1f}")


def edges_places() -> Rows:
    """Bias of the width and spread of an edge."""
    return _by_method(lambda found: f"{found['width_bias_px']:+.2f} / {found['spread_px']:.2f}")


def split_criterion() -> Rows:
    """Forests grown by either criterion: mean over seeds and its standard error."""
    found = summary("split_criterion")
    figures = {
        "rows with a false edge, %": ("rows_with_a_false_edge", 100.0, ".1f"),
        "limb rows within 1 px, %": ("limbs_within_1_px", 100.0, ".1f"),
        "width bias, px": ("width_bias_px", 1.0, "+.2f"),
        "spread, px": ("spread_px", 1.0, ".2f"),
    }
    rows = [
        (title, criterion, *(_over_seeds(one[scene][name], scale, form) for scene in EDGE_SCENES))
        for title, (name, scale, form) in figures.items()
        for criterion, one in found.items()
    ]
    return [("", "", *EDGE_SCENES), *rows]


def _over_seeds(values: list[float], scale: float, form: str) -> str:
    error = scale * stdev(values) / sqrt(len(values))
    return f"{scale * mean(values):{form}} ± {error:{form.lstrip('+')}}"


EDGE_TABLES: dict[str, Callable[[], Rows]] = {
    "fusion, metrics": fusion_metrics,
    "fusion, errors": fusion_errors,
    "fusion, windows": fusion_windows,
    "fusion, false edges": fusion_false_edges,
    "fusion, forest": fusion_forest,
    "edges, false": edges_false,
    "edges, found": edges_found,
    "edges, places": edges_places,
    "edges, criterion": split_criterion,
}
