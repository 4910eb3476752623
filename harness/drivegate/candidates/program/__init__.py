"""Any program that answers in lines of JSON."""
