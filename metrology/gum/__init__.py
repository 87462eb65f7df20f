"""Uncertainty of measurement by the GUM: inputs, propagation, Monte Carlo, budgets, regression, conformity."""
