"""A stranger's rules, one attack a row: contained, with the exit code and the text of the contracts. python3 -m unittest attacks"""

import rows
from attack_rows import FIXED, ROWS

Rows, update = rows.tests_of(__name__, ROWS, FIXED, __file__)

if __name__ == "__main__":
    rows.main(update)
