"""One module for each figure of the paper: its data in named units, and apart from that the drawing."""
