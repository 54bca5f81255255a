"""What there is to look at: pictures of tracks and frames; datasets and live drives in Rerun."""
