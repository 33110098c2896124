"""The report as a page and as Markdown, with its figures beside them."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from appliance.files.atomic_file import whole_file
from appliance.reproduction.experiment import Plot, Section, Table
from appliance.sizing.figures import figure_class, save_figure

PAGE, TEXT, FIGURES = "report.html", "report.md", "figures"
TITLE = "The dissertation made again"
SUBJECT = (
    'Yueda Lin, "Computer Vision Methods for Autonomous Remote Sizing in Manufacturing", doctoral dissertation, 2023. '
    "Every table and figure that shows a result, as printed there beside what this release measures."
)
WITHOUT_THE_PLANT = (
    "The plant's own videos are not published. What they alone can show is not imitated: figures 3.1, 3.2, 3.5, 3.18 "
    "to 3.21, 3.23, 3.24, 6.1 to 6.11 (scenes of the plant), and the plant's diameters, its truth. Here truth is what "
    "was drawn; scenes are those of the simulated mill, which shares no code with what is measured. Figures 3.3 to "
    "3.14, edges in pictures, stand with our own scenes in docs/methods/edges.md. A case is drawn from its seed: the "
    "same release gives the same figures, times excepted. ± is a standard error, a finding is confirmed or "
    "contradicted where its difference is more than two of them, and intervals of shares are of 95 %."
)
QUICK = "Quick: a few cases of each experiment; sampling errors are large."
VERDICTS = ("confirmed", "contradicted", "not decided")  # see `sampling.verdict`
STYLE = """
@page { size: A4; margin: 13mm 12mm }
body { font: 9pt/1.4 "DejaVu Sans", sans-serif; color: #000; margin: 8mm auto; max-width: 186mm }
h1 { font-size: 14pt }
h2 { font-size: 11pt; margin: 7mm 0 1mm; border-bottom: 0.3mm solid #000 }
h3 { font-size: 9pt; margin: 4mm 0 1mm }
table { border-collapse: collapse; width: 100%; font-size: 8pt }
th { text-align: left; border-bottom: 0.2mm solid #000 }
td, th { padding: 0.5mm 2mm 0.5mm 0; vertical-align: top }
td:first-child { white-space: nowrap }
td + td, th + th { text-align: right; font-variant-numeric: tabular-nums }
tr:nth-child(even) td { background: #f3f3f3 }
img { width: 100%; max-width: 160mm; display: block; margin: 1mm auto }
.note { font-size: 8pt; margin: 0 0 1mm }
figure, table { break-inside: avoid; margin: 1mm 0 }
"""


def write_report(output: Path, sections: Sequence[Section], *, quick: bool) -> Path:
    """Write the report.

    Parameters
    ----------
    output : Path
        Folder.
    sections : sequence of Section
    quick : bool
        Whether the report is of a few cases only.

    Returns
    -------
    Path
        The page; the Markdown lies beside it.

    Raises
    ------
    PlotsMissingError
        Matplotlib is not installed.
    OSError
        A file cannot be written.
    """
    (output / FIGURES).mkdir(exist_ok=True)
    for section in sections:
        for plot in section.plots:
            _draw(plot, output / FIGURES / f"{plot.name}.png")
    with whole_file(output / TEXT) as file:
        file.write(_markdown(sections, quick=quick))
    with whole_file(output / PAGE) as file:
        file.write(_page(sections, quick=quick))
    return output / PAGE


def _in_short(sections: Sequence[Section]) -> str:
    """How many findings of the dissertation are what."""
    whole = " ".join(finding for section in sections for finding in section.findings)
    counts = ", ".join(f"{whole.count(f': {verdict}')} {verdict}" for verdict in VERDICTS)
    return f"Findings of the dissertation that are held against the figures here: {counts}."


def _draw(plot: Plot, path: Path) -> None:
    figure = figure_class()(figsize=(8.5, 3.6), layout="constrained")
    axes = figure.subplots()
    plot.draw(axes)
    axes.grid(alpha=0.3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize="small")
    save_figure(figure, path)


def _markdown(sections: Sequence[Section], *, quick: bool) -> str:
    lines = [f"# {TITLE}", "", SUBJECT, "", WITHOUT_THE_PLANT, ""]
    lines += [_in_short(sections), ""]
    lines += [QUICK, ""] if quick else []
    for section in sections:
        lines += [f"## {section.title}", "", section.conditions, ""]
        for table in section.tables:
            lines += [f"**{table.title}**", "", *_table_lines(table), ""]
            lines += [table.note, ""] if table.note else []
        lines += [f"- {finding}" for finding in section.findings]
        lines += [""]
        for plot in section.plots:
            lines += [f"![{plot.title}]({FIGURES}/{plot.name}.png)", ""]
    return "\n".join(lines).rstrip() + "\n"


def _table_lines(table: Table) -> list[str]:
    head = [f"| {' | '.join(table.columns)} |", "| --- " * len(table.columns) + "|"]
    return head + [f"| {' | '.join(row)} |" for row in table.rows]


def _page(sections: Sequence[Section], *, quick: bool) -> str:
    parts = [f"<h1>{TITLE}</h1>", f"<p>{escape(SUBJECT)}</p>", f"<p>{escape(WITHOUT_THE_PLANT)}</p>"]
    parts += [f"<p>{escape(_in_short(sections))}</p>"]
    parts += [f"<p><b>{QUICK}</b></p>"] if quick else []
    for section in sections:
        parts += [f"<h2>{escape(section.title)}</h2>", f"<p>{escape(section.conditions)}</p>"]
        for table in section.tables:
            parts += [f"<h3>{escape(table.title)}</h3>", _html_table(table)]
        parts += ["<ul>", *(f"<li>{escape(finding)}</li>" for finding in section.findings), "</ul>"]
        for plot in section.plots:
            image = f'<img src="{FIGURES}/{plot.name}.png" alt="{escape(plot.title)}">'
            parts += [f"<figure>{image}<figcaption>{escape(plot.title)}</figcaption></figure>"]
    head = f'<meta charset="utf-8"><title>{TITLE}</title><style>{STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(parts) + "\n</body></html>\n"


def _html_table(table: Table) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in table.rows)
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    return f"<table><tr>{head}</tr>" + "".join(f"<tr>{row}</tr>" for row in rows) + f"</table>{note}"
