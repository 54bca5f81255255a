"""One command a file: read, call one function, write, say what was written."""
