"""Virtual time: the student's program runs by the judge's clock."""
