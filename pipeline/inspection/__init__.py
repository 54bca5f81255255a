"""Pictures to look at: tracks and sample frames."""
