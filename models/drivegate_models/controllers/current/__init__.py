"""The built-in controllers and the blocks that they are made of."""
