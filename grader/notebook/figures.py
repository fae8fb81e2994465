"""Figures that follow the notebook's theme: clear paper, and in a dark theme inverted lightness."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHARPNESS = 2  # pixels for each of CSS: for screens with small ones
OURS = "course"  # attribute of our figures: others keep the look that their notebook gave them
# JupyterLab and Notebook, VS Code, Colab. The filter turns black to white and keeps the hues.
STYLE = """\
<style>
[data-jp-theme-light="false"] img.course-plot, .vscode-dark img.course-plot,
html[theme="dark"] img.course-plot { filter: invert(.93) hue-rotate(180deg); }
</style>"""


def follow_theme(figure: Figure) -> None:
    """Let a notebook show a figure in its own theme; elsewhere nothing changes."""
    setattr(figure, OURS, True)
    from grader.notebook.show import in_notebook, shell  # noqa: PLC0415

    if in_notebook():
        from matplotlib.figure import Figure  # noqa: PLC0415

        shell().display_formatter.formatters["text/html"].for_type(Figure, figure_html)


def figure_html(figure: Figure) -> str | None:
    """Return a figure of ours as HTML; None for others, which are shown as ever."""
    if not getattr(figure, OURS, False):
        return None
    picture = io.BytesIO()
    figure.savefig(
        picture, format="png", dpi=SHARPNESS * figure.dpi, bbox_inches="tight", transparent=True
    )
    data = picture.getvalue()
    width = int.from_bytes(data[16:20], "big") // SHARPNESS  # [CSS pixels] of PNG's first chunk
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    said = html.escape(f"Plot: {'; '.join(titles)}" if titles else "Plot")
    return (
        f'{STYLE}<img class="course-plot" width="{width}" style="max-width:100%" alt="{said}" '
        f'src="data:image/png;base64,{base64.b64encode(data).decode("ascii")}">'
    )
