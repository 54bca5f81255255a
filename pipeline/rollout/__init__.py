"""Who drives and who is asked: strategies, the closed loop, plans and seeds, budgets, workers."""
