"""What campaigns of controllers of duty ratios have of their own."""
