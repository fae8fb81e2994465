"""Known solutions, right and wrong, and what each claims: which checks it passes or fails."""
