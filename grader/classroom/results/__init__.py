"""The results of a graded class: the class report, feedback pages, gradebooks."""
