"""References of the methods used: key → full reference, as the report prints it."""

from __future__ import annotations

from collections.abc import Iterable

REFERENCES = {
    "jcgm100": "JCGM 100:2008, Evaluation of measurement data — Guide to the expression of uncertainty in measurement "
    "(GUM).",
    "jcgm101": "JCGM 101:2008, Supplement 1 to the GUM — Propagation of distributions using a Monte Carlo method.",
    "jcgm102": "JCGM 102:2011, Supplement 2 to the GUM — Extension to any number of output quantities.",
    "jcgm106": "JCGM 106:2012, The role of measurement uncertainty in conformity assessment.",
    "vim": "JCGM 200:2012, International vocabulary of metrology (VIM), 3rd edition.",
    "ilac-g8": "ILAC-G8:09/2019, Guidelines on decision rules and statements of conformity.",
    "iso17025": "ISO/IEC 17025:2017, General requirements for the competence of testing and calibration laboratories.",
    "iso13528": "ISO 13528:2022, Statistical methods for use in proficiency testing by interlaboratory comparison.",
    "cox": "M. G. Cox, The evaluation of key comparison data, Metrologia 39 (2002) 589.",
    "paule": "R. C. Paule, J. Mandel, Consensus values and weighting factors, J. Res. Natl. Bur. Stand. 87 (1982) 377.",
    "knapp": "G. Knapp, J. Hartung, Improved tests for a random effects meta-regression with a single covariate, "
    "Statist. Med. 22 (2003) 2693.",
    "iso28037": "ISO/TS 28037:2010, Determination and use of straight-line calibration functions.",
    "paper": "Space tethers: parameters reconstructions and tests (the paper whose measurement chain is followed: "
    "dead-load elongation, free decay, response tests on a low-friction table).",
    "decrement": "J. P. Den Hartog, Mechanical Vibrations, 4th edition (logarithmic decrement).",
    "welch": "B. L. Welch, The generalization of 'Student's' problem, Biometrika 34 (1947); JCGM 100:2008 G.4.",
    "willink": "R. Willink, A generalization of the Welch–Satterthwaite formula for use with correlated uncertainty "
    "components, Metrologia 44 (2007).",
    "vv20": "ASME V&V 20-2009, Standard for verification and validation in computational fluid dynamics and heat "
    "transfer.",
    "sprague": "M. A. Sprague, T. L. Geers, A spectral-element method for modelling cavitation in transient "
    "fluid-structure interaction, Int. J. Numer. Meth. Engng 60 (2004).",
    "marquardt": "D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11 "
    "(1963) 431.",
    "neldermead": "J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7 (1965) 308.",
    "profile": "D. J. Venzon, S. H. Moolgavkar, A method for computing profile-likelihood-based confidence intervals, "
    "Appl. Statist. 37 (1988) 87.",
    "geyer": "C. J. Geyer, Practical Markov chain Monte Carlo, Statist. Sci. 7 (1992) 473 (correlation length).",
    "gasser": "T. Gasser, L. Sroka, C. Jennen-Steinmetz, Residual variance and residual pattern in nonlinear "
    "regression, Biometrika 73 (1986) 625.",
    "golub": "G. H. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems "
    "whose variables separate, SIAM J. Numer. Anal. 10 (1973) 413.",
    "mackay": "D. J. C. MacKay, Information Theory, Inference, and Learning Algorithms, Cambridge University Press "
    "2003 (evidence).",
    "jackknife": "B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982.",
    "iso7500": "ISO 7500-1:2018, Metallic materials — Calibration and verification of static uniaxial testing machines "
    "— Part 1: Tension/compression testing machines.",
    "iso9513": "ISO 9513:2012, Metallic materials — Calibration of extensometer systems used in uniaxial testing.",
    "hac": "E. Lazarus, D. J. Lewis, J. H. Stock, M. W. Watson, HAR inference: recommendations for practice, J. Bus. "
    "Econ. Stat. 36 (2018) 541.",
    "ferry": "J. D. Ferry, Viscoelastic Properties of Polymers, 3rd edition, Wiley 1980.",
    "tschoegl": "N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer 1989.",
    "irvine": "H. M. Irvine, Cable Structures, MIT Press 1981 (elastic catenary).",
}
"""Key → reference; the keys are used in code and never change."""


def cite(keys: Iterable[str]) -> tuple[str, ...]:
    """Full references of `keys`, each once, in the order of the table.

    Raises
    ------
    KeyError
        For a key that is not in the table.
    """
    wanted = set(keys)
    if unknown := wanted - REFERENCES.keys():
        raise KeyError(f"references without an entry: {', '.join(sorted(unknown))}")
    return tuple(text for key, text in REFERENCES.items() if key in wanted)
