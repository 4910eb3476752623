"""What the kernel enforces on a process that runs code of strangers; knows nothing of candidates."""
