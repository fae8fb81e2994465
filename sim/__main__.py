"""`python -m sim`: the mock robot as a ROS 2 node (see `sim.live.cli`)."""

import sys

from sim.live.cli import main

sys.exit(main())
