"""The replay player: one HTML page without dependencies."""
