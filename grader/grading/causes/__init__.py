"""Why a grading failed: what the recordings show; see `find`."""
