"""Short ways to write inputs and models for the tests of the GUM engine."""

from metrology import gum


def quantity(name, value, *distributions, dof=(), unit="1"):
    """Input with one component per distribution; `dof` gives degrees of freedom to the first ones."""
    freedom = [*dof, *[float("inf")] * (len(distributions) - len(dof))]
    parts = zip(distributions, freedom, strict=True)
    return gum.Input(name, value, tuple(gum.Component(f"c{i}", d, nu) for i, (d, nu) in enumerate(parts)), unit)


def knowledge(*inputs, ensembles=(), correlations=None):
    return gum.Knowledge({item.name: item for item in inputs}, tuple(ensembles), correlations or {})


def model(expression, name="y", unit="1"):
    """Measurand from a Python expression over names of inputs and the functions of the engine (test code only)."""
    from metrology.gum.functions import FUNCTIONS

    code = compile(expression, name, "eval")
    return gum.Measurand(name, lambda q: eval(code, {**FUNCTIONS, "pi": 3.141592653589793}, dict(q)), unit)
