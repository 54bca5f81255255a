"""SafeDAgger as a library: no command line, no printing, no global state."""
