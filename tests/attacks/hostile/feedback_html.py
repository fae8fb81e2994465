"""Put HTML and script into everything that a report shows: log lines, names, the exception.

gains: nothing
score: 0
outcome: exception
"""

from kit import drive

SCRIPT = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>"


def inject(node, scan):
    node.get_logger().error(SCRIPT)
    print(SCRIPT, "<!--", "]]>", "\u2028")
    raise RuntimeError(SCRIPT)


drive(inject)
