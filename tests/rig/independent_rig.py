"""A rig of our own making for the tests: SciPy's DOP853 at rtol 1e-12, each regime on its own, ended by SciPy's events.

Shares no code with `metrology.rig`; the equations are written from the definitions in docs/model.md, with brentq for
what is implicit.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

NULLS = {
    "mass.factor": 1, "free_length.shift": 0, "friction.force": 0, "friction.static_ratio": 1, "friction.bias": 0,
    "drag.viscous": 0, "drag.quadratic": 0, "tilt.angle": 0, "setup.compliance": 0, "frame.compliance": 0,
    "frame.frequency": 1190, "frame.damping": 0.02, "cubic.stiffness": 0, "toe.extent": 0, "toe.ratio": 0.5,
    "zener.stiffness": 0, "zener.time": 1, "second_branch.stiffness": 0, "second_branch.time": 1,
    "damping.amplitude": 0, "hysteresis.stiffness": 0, "hysteresis.yield": 1e-3, "sag.weight": 0,
    "thrust.gain": 1, "thrust.lag": 0, "thrust.delay": 0, "thrust.fading": 0,
    "slip.set": 0, "yaw.arm": 0, "yaw.inertia": 1,
    "yaw.frequency": 0.5, "yaw.damping": 0.02, "cell.gain": 1, "cell.zero": 0, "cell.drift": 0, "motion.scale": 1,
    "clock.x": 0, "clock.v": 0, "clock.T": 0, "hum.x": 0, "hum.v": 0, "hum.T": 0, "hum.frequency": 50, "hum.phase": 0,
    "start.x": 0, "start.v": 0, "even.stiffness": 0, "line_damping.quadratic": 0, "asymmetric_damping.outward": 0,
    "hose.stiffness": 0, "hose.rest": 0, "stop.stiffness": 0, "stop.gap": 0,
    "slack.share": 0, "slack.place": 1e-3, "slack.damping": 1,
    "sine.rate": 0, "gain_drift.rate": 0, "cell_lag.time": 0,
    "appendage.mass": 0, "appendage.frequency": 10, "appendage.damping": 0.02,
}  # fmt: skip


class Reference:
    """One run: `solve(t, x0, v0, edges)` gives x, v, T as the instruments read them."""

    def __init__(self, m, k, c, taut, line="tether", length=3.0, weight=0.0, eq3=False, cap=0.005, g=9.8, **effects):
        given = {name.replace("__", "."): value for name, value in effects.items()}
        assert set(given) <= set(NULLS), set(given) - set(NULLS)
        self.e = {**NULLS, **given}
        self.m, self.k, self.c = m * self.e["mass.factor"], k, c
        self.taut = taut + self.e["free_length.shift"]
        self.line, self.length, self.weight, self.eq3, self.cap, self.g = line, length, weight, eq3, cap, g

    # states: x, v, u, u', phi, phi', z, h, F, of the appendage where it is in space: X + y, and its rate; z_b;
    # where it lags, what the cell reads
    def elastic(self, epsilon, z, h):
        """Static tension of the material."""
        e, size = self.e, abs(epsilon)
        toe, ratio = e["toe.extent"], e["toe.ratio"]
        knee = ratio * self.k * size if size <= toe else self.k * (size - (1 - ratio) * toe)
        base = math.copysign(knee, epsilon) if toe > 0 else self.k * epsilon
        kappa = e["sine.rate"]
        return (
            base
            + (self.k * (math.sin(kappa * epsilon) / kappa - epsilon) if kappa else 0.0)
            + e["even.stiffness"] * epsilon**2
            + e["cubic.stiffness"] * epsilon**3
            + e["zener.stiffness"] * (epsilon - z[0])
            + e["second_branch.stiffness"] * (epsilon - z[1])
            + e["hysteresis.stiffness"] * h
        )

    def strain(self, excess, z, h):
        """ε and dε/de, by root finding; z of both branches."""
        C, q = self.e["setup.compliance"], self.e["sag.weight"]
        if q == 0 and C == 0:
            return excess, 1.0
        s = self.length

        def span(T):  # of the hanging line, ends at equal height (Irvine, Cable Structures, 1.2)
            return 2 * T / q * math.asinh(q * s / (2 * T))

        def miss(epsilon):
            T = self.elastic(epsilon, z, h)
            return epsilon + C * T - (s - span(T) if q else 0.0) - excess

        if q == 0:
            low, high = min(0.0, excess) - 1e-3, max(0.0, excess) + 1e-3
        else:
            low, high = 1e-14, max(excess, 0.0) + 10 * (q**2 * s**3 / 24 / self.k**2) ** (1 / 3)
        epsilon = brentq(miss, low, high, xtol=1e-18, rtol=1e-15)
        d = 1e-6 * max(abs(epsilon), 1e-9)
        branches = self.e["zener.stiffness"] + self.e["second_branch.stiffness"]
        slope = (self.elastic(epsilon + d, z, h) - self.elastic(epsilon - d, z, h)) / (2 * d)
        if self.e["toe.extent"] > 0:
            inside = abs(epsilon) < self.e["toe.extent"]
            slope = self.k * (self.e["toe.ratio"] if inside else 1.0) + branches
        elif not any(self.e[name] for name in ("cubic.stiffness", "even.stiffness", "sine.rate")):
            slope = self.k + branches
        T = self.elastic(epsilon, z, h)
        longer = s / math.hypot(T, q * s / 2) - span(T) / T if q else 0.0  # −d(span)/dT
        return epsilon, 1 / (1 + (C - longer) * slope)

    def geometry(self, y):
        arm = self.e["yaw.arm"]
        return y[0] - self.taut - y[2] - arm * y[4], y[1] - y[3] - arm * y[5]

    def taut_pull(self, y):
        excess, rate = self.geometry(y)
        epsilon, share = self.strain(excess, y[[6, 11]], y[7])
        damping = self.c + self.e["damping.amplitude"] * abs(epsilon)
        quadratic = self.e["line_damping.quadratic"] * share**3 * rate * abs(rate)
        outward = self.e["asymmetric_damping.outward"] * share**2 * max(rate, 0.0)
        taut = self.elastic(epsilon, y[[6, 11]], y[7]) + damping * share**2 * rate + quadratic + outward
        side = 1 if self.e["slack.place"] >= 0 else -1
        return taut - self.e["slack.share"] * side * max(side * self.pushed(y), 0.0)

    def pushed(self, y):
        excess, rate = self.geometry(y)
        return self.k * (excess - self.e["slack.place"]) + self.e["slack.damping"] * self.c * rate

    def tension(self, y, contact):
        if self.line == "none":
            return 0.0
        if contact == "taut":
            return self.taut_pull(y)
        if not self.eq3:
            return 0.0
        gap = max(-self.geometry(y)[0], self.cap)
        L = self.length - gap
        return self.weight * L**2 / (8 * math.sqrt(3 * L * gap / 8))

    def force(self, y, contact, thrust):
        e, v = self.e, y[1]
        push = y[8] if e["thrust.lag"] > 0 else thrust
        tilt = self.m * self.g * math.sin(e["tilt.angle"])
        push -= e["hose.stiffness"] * (y[0] - e["hose.rest"])
        beyond = y[0] - e["stop.gap"]
        push -= e["stop.stiffness"] * beyond * (beyond * (1 if e["stop.gap"] >= 0 else -1) > 0)
        pulled = push + tilt - e["drag.viscous"] * v - e["drag.quadratic"] * v * abs(v) - self.tension(y, contact)
        return pulled + self.carried(y)

    def carried(self, y):
        """Pull of the appendage on the module: its spring and its damper between the two."""
        part, w = self.e["appendage.mass"], self.e["appendage.frequency"]
        apart, rate = y[9] - (y[0] - self.x0), y[10] - y[1]
        return part * w**2 * apart + 2 * self.e["appendage.damping"] * part * w * rate

    def rhs(self, t, y, contact, slide, thrust):
        thrust *= 1 - self.e["thrust.fading"] * (t - self.begun)
        e, out = self.e, np.zeros(len(y))
        if slide != 0:
            held = (slide + e["friction.bias"]) * e["friction.force"]
            rigid = self.m - e["appendage.mass"]
            out[0], out[1] = y[1], (self.force(y, contact, thrust) - held) / rigid
        if e["appendage.mass"]:
            out[9], out[10] = y[10], -self.carried(y) / e["appendage.mass"]
        T = self.tension(y, contact)
        wf, zf = e["frame.frequency"], e["frame.damping"]
        out[2], out[3] = y[3], wf**2 * (e["frame.compliance"] * T - y[2]) - 2 * zf * wf * y[3]
        wy, zy = e["yaw.frequency"], e["yaw.damping"]
        out[4], out[5] = y[5], e["yaw.arm"] * T / e["yaw.inertia"] - wy**2 * y[4] - 2 * zy * wy * y[5]
        excess, rate = self.geometry(y)
        epsilon, speed = 0.0, 0.0
        if contact != "below":
            epsilon, share = self.strain(excess, y[[6, 11]], y[7])
            speed = share * rate
        out[6] = (epsilon - y[6]) / e["zener.time"] if e["zener.stiffness"] else 0.0
        out[11] = (epsilon - y[11]) / e["second_branch.time"] if e["second_branch.stiffness"] else 0.0
        h = y[7]
        if e["hysteresis.stiffness"]:
            out[7] = speed * (1 - 0.5 * (1 + np.sign(speed * h)) * abs(h / e["hysteresis.yield"]))
        if e["thrust.lag"] > 0:
            out[8] = (thrust - y[8]) / e["thrust.lag"]
        if e["cell_lag.time"] > 0:
            out[12] = (T - y[12]) / e["cell_lag.time"]
        return out

    def conditions(self, y0, contact, slide, slipped, thrust):  # noqa: C901 - a list of all that ends a regime
        """(name, function, direction) of everything that ends this regime."""
        e, found = self.e, []
        sags = e["sag.weight"] > 0
        if self.line == "tether":
            if not sags:
                found.append(("line", lambda t, y: self.geometry(y)[0], 1 if contact == "below" else -1))
            if contact != "below":
                found.append(("pull", lambda t, y: self.taut_pull(y), -1 if contact == "taut" else 1))
            if self.eq3 and contact == "below":
                found.append(("cap", lambda t, y: self.geometry(y)[0] + self.cap, 0))
        if slide == 0:
            limit = e["friction.static_ratio"] * e["friction.force"]
            bias = e["friction.bias"]

            def loose(t, y):
                net = self.force(y, contact, thrust)
                return max(net / (1 + bias), -net / (1 - bias)) - limit

            found.append(("slip", loose, 1))
        elif (e["friction.force"] or e["drag.quadratic"]) and (y0[1] or self.force(y0, contact, thrust)):
            found.append(("speed", lambda t, y: y[1], -slide))
        if e["slack.share"]:
            found.append(("kink", lambda t, y: self.pushed(y), 0))
        if contact != "below":
            if e["toe.extent"]:
                found.append(
                    (
                        "toe",
                        lambda t, y: abs(self.strain(self.geometry(y)[0], y[[6, 11]], y[7])[0]) - e["toe.extent"],
                        0,
                    )
                )
            if e["hysteresis.stiffness"]:
                found += [("kink", lambda t, y: self.geometry(y)[1], 0), ("kink", lambda t, y: y[7], 0)]
            if e["damping.amplitude"] and self.line == "both ways":
                found.append(("kink", lambda t, y: self.geometry(y)[0], 0))
            if e["slip.set"] and not slipped and contact == "taut":
                found.append(("clamp", lambda t, y: self.geometry(y)[1], -1))
        return found

    def touch(self, y):
        if self.line == "none":
            return "below"
        if self.line == "both ways":
            return "taut"
        excess, rate = self.geometry(y)
        if self.e["sag.weight"] == 0 and (excess < 0 or (excess == 0 and rate <= 0)):
            return "below"
        return "taut" if self.taut_pull(y) >= 0 else "lifted"

    def grip(self, y, contact, thrust):
        if y[1] != 0:
            return int(np.sign(y[1]))
        net = self.force(y, contact, thrust)
        way = 1 if net >= 0 else -1
        limit = self.e["friction.static_ratio"] * self.e["friction.force"] * (1 + way * self.e["friction.bias"])
        return 0 if self.e["friction.force"] and abs(net) <= limit else way

    def settle(self, y):
        """Frame and yaw at rest under the pull of the line."""
        e = self.e
        soft = e["frame.compliance"], e["yaw.arm"] / (e["yaw.inertia"] * e["yaw.frequency"] ** 2)

        def miss(T):
            y[2], y[4] = soft[0] * T, soft[1] * T
            left = self.geometry(y)[0]
            return self.elastic(self.strain(left, (left, left), 0.0)[0], (left, left), 0.0) - T

        if any(soft):
            most = 1.1 * self.k * abs(y[0] - self.taut)
            miss(brentq(miss, -most, most, xtol=1e-16, rtol=1e-15))

    def solve(self, t, x0, v0, edges, *, rtol=1e-12, most=4000, longest=None):  # noqa: C901 - one loop over regimes
        """`edges`: list of (time, force). Samples at t (each channel less its clock)."""
        e = self.e
        wanted = [np.asarray(t) - e[f"clock.{name}"] for name in "xvT"]
        outs = [np.full(len(t), np.nan) for _ in range(3)]
        now, end = 0.0, max(w[-1] for w in wanted)
        y = np.zeros(13 if e["cell_lag.time"] > 0 else 12)
        y[0], y[1] = x0 + e["start.x"], v0 + e["start.v"]
        self.x0, y[10] = y[0], y[1]  # the appendage at rest on the module
        self.begun = edges[0][0] + e["thrust.delay"] if edges else 0.0
        edges = [(at + e["thrust.delay"], e["thrust.gain"] * force) for at, force in edges]
        thrust = next((f for at, f in reversed(edges) if at <= now), 0.0)
        slipped, moved = False, 0.0
        contact = self.touch(y)
        if contact != "below":
            self.settle(y)
            y[6] = y[11] = self.geometry(y)[0]
        if e["cell_lag.time"] > 0:
            y[12] = self.tension(y, contact)
        slide = self.grip(y, contact, thrust)
        events = []
        for _ in range(most):
            stop = min([at for at, _ in edges if at > now] + [end])
            found = self.conditions(y, contact, slide, slipped, thrust)
            functions = []
            for _, function, direction in found:

                def wrapped(t, y, *rest, function=function):
                    return function(t, y)

                wrapped.terminal, wrapped.direction = True, direction
                functions.append(wrapped)
            omega = math.sqrt(self.k / self.m + (e["frame.frequency"] ** 2 if e["frame.compliance"] else 0))
            result = solve_ivp(
                self.rhs, (now, stop), y, method="DOP853", rtol=rtol, atol=1e-15, events=functions or None,
                args=(contact, slide, thrust), dense_output=True, max_step=longest or 0.5 / omega,
                first_step=min(1e-4, (stop - now) / 2) or None,
            )  # fmt: skip
            assert result.success, result.message
            leg = result.t[-1]
            for channel in range(3):
                inside = np.flatnonzero((wanted[channel] >= now) & (wanted[channel] <= leg) & np.isnan(outs[channel]))
                if inside.size:
                    states = result.sol(wanted[channel][inside])
                    if channel < 2:
                        outs[channel][inside] = states[channel]
                    else:
                        lags = e["cell_lag.time"] > 0
                        outs[2][inside] = states[12] if lags else [self.tension(s, contact) for s in states.T]
            now, y = leg, result.y[:, -1].copy()
            if result.status == 0:
                if now >= end:
                    break
                thrust = next(f for at, f in reversed(edges) if at <= now + 1e-12)
                if y[1] == 0 or slide == 0:
                    slide = self.grip(y, contact, thrust)
                continue
            which = next(i for i, times in enumerate(result.t_events) if times.size)
            name = found[which][0]
            events.append((now, name))
            if name == "line":
                beyond = "taut" if contact == "below" and self.taut_pull(y) >= 0 else "lifted"
                contact = beyond if contact == "below" else "below"
            elif name == "pull":
                contact = "lifted" if contact == "taut" else "taut"
            elif name == "speed":
                y[1] = 0.0
                slide = self.grip(y, contact, thrust)
            elif name == "slip":
                slide = int(np.sign(self.force(y, contact, thrust)))
            elif name == "clamp":
                slipped = True
                self.taut += e["slip.set"]
                moved = e["slip.set"]
                contact = self.touch(y)
            # step over the root, or SciPy would find it again
            nudge = self.rhs(now, y, contact, slide, thrust)
            step = 1e-13
            y, now = y + step * nudge, now + step
        else:
            raise AssertionError("too many events")
        self.taut -= moved
        x, v, T = outs
        stamps = np.asarray(t)
        hum = [e[f"hum.{n}"] * np.sin(2 * np.pi * e["hum.frequency"] * stamps + e["hum.phase"]) for n in "xvT"]
        x, v = e["motion.scale"] * x + hum[0], e["motion.scale"] * v + hum[1]
        T = (e["cell.gain"] + e["gain_drift.rate"] * stamps) * T + e["cell.zero"] + e["cell.drift"] * stamps + hum[2]
        return SimpleNamespace(x=x, v=v, T=T, events=events)
