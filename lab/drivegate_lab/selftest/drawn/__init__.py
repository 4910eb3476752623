"""The reference and the faulty controllers on drives that are drawn at random."""
