"""All that leaves: progress, console, files, report pages, and failures in one sentence."""
