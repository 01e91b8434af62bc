int nothing_of_interest() { return 1; }
