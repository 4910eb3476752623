"""One check of one candidate, as events: plan, run, search, shrink, record."""
