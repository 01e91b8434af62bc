"""Wrong inputs, one a row: exit code, place and remedy. python3 -m unittest wrong_inputs"""

import rows
from wrong_input_rows import FIXED, ROWS

Rows, update = rows.tests_of(__name__, ROWS, FIXED, __file__)

if __name__ == "__main__":
    rows.main(update)
