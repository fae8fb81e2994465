"""What a host may not do."""
