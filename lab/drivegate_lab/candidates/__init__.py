"""Faulty controllers, which checks must catch, and correct ones of other designs, which none may accuse."""
