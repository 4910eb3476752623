"""What listens to a check's events: progress on the console, and the files of the report."""
