"""A controller of duty ratios whose senses and answers are spoilt on the way, for checks to be checked by."""
