"""Uncertainty of measurement by the GUM: inputs, propagation, Monte Carlo, budgets, regression, conformity."""

from metrology.gum.bounded import Arcsine, CurvilinearTrapezoid, Rectangular, Trapezoidal, Triangular
from metrology.gum.distributions import DISTRIBUTIONS, Normal, Student
from metrology.gum.engine import evaluate, evaluate_law
from metrology.gum.evaluation import BudgetRow, Coverage, Estimate, Evaluation, Measurand, MonteCarlo
from metrology.gum.influence import Distribution
from metrology.gum.inputs import Component, Ensemble, Input, Knowledge
from metrology.gum.law import coverage_factor
from metrology.gum.readings import mean, observed, simultaneous, standard_deviation, type_a

__all__ = [
    "DISTRIBUTIONS",
    "Arcsine",
    "BudgetRow",
    "Component",
    "Coverage",
    "CurvilinearTrapezoid",
    "Distribution",
    "Ensemble",
    "Estimate",
    "Evaluation",
    "Input",
    "Knowledge",
    "Measurand",
    "MonteCarlo",
    "Normal",
    "Rectangular",
    "Student",
    "Trapezoidal",
    "Triangular",
    "coverage_factor",
    "evaluate",
    "evaluate_law",
    "mean",
    "observed",
    "simultaneous",
    "standard_deviation",
    "type_a",
]
