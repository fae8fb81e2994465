"""Close the link and the output, and go on in silence.

gains: nothing
score: 0
outcome: died, hung, exception
"""

import os

from kit import drive

drive(lambda node, scan: os.closerange(0, 60))
