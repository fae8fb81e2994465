"""What learning platforms hand over, and what they take back; see `platforms`."""
