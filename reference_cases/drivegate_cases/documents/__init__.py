"""Reading, checking and writing any document, and sentences about what is wrong in one."""
