"""Missing in a browser; imported, never called, in the page."""
