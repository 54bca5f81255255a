"""How well the policies drive and what it cost: outcomes, metrics, figures, the report."""
