"""Worker processes that hold a candidate: bounded in time and memory, and nothing left behind."""
