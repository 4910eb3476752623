"""Facts and findings of the paper."""
