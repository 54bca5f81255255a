"""Other worlds, through LeRobot and Gymnasium: an adapter each, which knows the seam and no more."""
