"""The faulty controllers, a module for each kind of fault."""
