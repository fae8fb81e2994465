"""What the hosts of one launcher do."""

NODES = "nodes"  # in virtual time
SCRIPTS = "scripts"  # which return
LIVE = "live"  # nodes, in real time
TESTS = "tests"  # of pytest's, in virtual time
