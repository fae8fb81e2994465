"""What the course says to beginners of their programs: slips, exceptions, refusals."""
