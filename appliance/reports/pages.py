"""Pages from templates, as HTML that stands alone or as PDF."""

import base64
import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from appliance.errors import HotgaugeError
from appliance.files.atomic_file import whole_place


class ReportMissingError(HotgaugeError):
    """A library that makes pages is not installed; the message says what to do."""


def library(name: str, output: Path) -> Any:
    """A library that makes pages.

    Parameters
    ----------
    name : str
    output : Path
        File that is to be written, for the sentence that refuses.

    Raises
    ------
    ReportMissingError
    """
    try:
        return importlib.import_module(name)
    except (ImportError, OSError) as error:  # OSError: the library is there, and Debian's Pango is not
        words = "pages need: pip install jinja2 matplotlib weasyprint, and apt-get install libpangoft2-1.0-0"
        raise ReportMissingError(f"{output}: {words} ({error})") from error


def render(
    text: str, output: Path, values: Mapping[str, object], filters: Mapping[str, Callable[..., str]] | None = None
) -> str:
    """HTML of a template.

    Parameters
    ----------
    text : str
        Template of Jinja; it may include `pages.css`, the style of reports.
    output : Path
        File that is to be written, for the sentence that refuses.
    values : mapping of str to object
        What the template names.
    filters : mapping of str to callable, optional
        Beside Jinja's own.

    Raises
    ------
    ReportMissingError
    """
    jinja = library("jinja2", output)
    loader = jinja.PackageLoader("appliance.reports", "")
    environment: Any = jinja.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= dict(filters or {})
    return environment.from_string(text).render(values)


def data_address(svg: str) -> str:
    """Address that holds an SVG picture itself; empty for an empty one."""
    return svg and "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def write_pages(html: str, output: Path) -> None:
    """Write HTML, or PDF if the suffix is `.pdf`; raises `OSError` and `ReportMissingError`.

    Parameters
    ----------
    html : str
    output : Path
    """
    weasyprint = library("weasyprint", output) if output.suffix.lower() == ".pdf" else None
    with whole_place(output) as place:
        if weasyprint is None:
            place.write_text(html, encoding="utf-8")
        else:
            weasyprint.HTML(string=html).write_pdf(place)
