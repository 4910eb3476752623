"""The faulty controllers, a module for each family of fault."""
