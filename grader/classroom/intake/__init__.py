"""Take in what a class handed in: every file is graded, or the account says why not."""
