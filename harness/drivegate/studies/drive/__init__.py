"""What a drive can do, before anyone is judged on it."""
