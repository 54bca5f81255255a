"""How well the policies drive: outcomes of drives, metrics, and comparisons with intervals."""
