"""Who drives, and who is asked: a rule a file. One of your own is a subclass of `Rule`."""
