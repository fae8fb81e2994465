"""Show a replay below a cell: the report's page in an iframe that can reach nothing else."""

import html

HEIGHT = 960  # [px]
# A page in a frame takes its colour scheme from the frame: JupyterLab, nbconvert, VS Code, Colab.
STYLE = """\
<style>
[data-jp-theme-light="false"] iframe.course-replay, .vscode-dark iframe.course-replay,
html[theme="dark"] iframe.course-replay { color-scheme: dark; }
[data-jp-theme-light="true"] iframe.course-replay, .vscode-light iframe.course-replay,
html[theme="light"] iframe.course-replay { color-scheme: light; }
</style>"""


def frame_html(page: str, *, title: str) -> str:
    """Return an inline frame with a page; it needs no URL, no network and no widgets.

    The frame is sandboxed: what a student's node wrote into the page can't reach the notebook.
    """
    return (
        f'{STYLE}<iframe class="course-replay" srcdoc="{html.escape(page)}" '
        f'title="{html.escape(title)}" '
        f'sandbox="allow-scripts" loading="lazy" width="100%" height="{HEIGHT}" '
        'style="border:1px solid rgba(128,128,128,.35);border-radius:8px;'
        'max-width:1180px;display:block"></iframe>'
    )


def folded(summary: str, content: str, *, unfolded: bool = False) -> str:
    """Return content in a foldable block below its summary."""
    state = " open" if unfolded else ""
    return (
        f'<details{state} style="margin-top:8px"><summary style="cursor:pointer;padding:4px 0">'
        f"{html.escape(summary)}</summary>{content}</details>"
    )
