"""Derivatives of a motion by its parameters, carried along its legs and through its events.

Between two events y′ = f(y, F, p) gives S′ = f_y·S + f_F·F_p + f_p for S = dy/dp (forward sensitivities). At an event,
where g(y, F, p) = 0, the time of the event moves by δt = −(g_y·S + g_F·F_p + g_p)/g′ and S⁺ = S⁻ + (f⁻ − f⁺)·δt + h_p,
h_p the derivative of a jump of y (saltation matrix: Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth
Mechanical Systems, Springer 2004, 7.2). A linear regime is followed by the exponential of its matrix and that
exponential's derivative, a nonlinear one by collocation along the steps of the motion. What is differentiated by the
parameters (f, g and the matrices) is smooth within a regime: there central differences have ten digits.

Compiled together with `kernel`, whose equation it shares; the motion's legs come from `kernel.march.march_many`.
"""

from metrology.rig.tangent import collocation, differences, events, exponential, samples, trace

MODULES = (differences, events, exponential, samples, collocation, trace)
"""Of these the later ones use the earlier ones', and all of them the kernel's."""
