"""What users require of their own product: rows of when, within, quantity and limit, and scenarios of their own."""
