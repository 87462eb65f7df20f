"""The model as stated, fitted by least squares: what all the simple entries begin with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchmarks.causes.closed import base_motion
from benchmarks.causes.rig import Push, Rig

from .records import Campaign, Record, si


@dataclass(frozen=True)
class Fitted:
    """Value and interval of k and c, χ² for each reading, and residuals over noise of every record by channel."""

    k: tuple[float, float, float]
    c: tuple[float, float, float] | None
    chi: float
    residuals: dict[str, dict[str, np.ndarray]]
    held_out: float | None

    @property
    def noise_only(self) -> bool:
        """Whether χ² is that of white noise, within five standard deviations."""
        count = sum(r.size for record in self.residuals.values() for r in record.values())
        return self.chi < 1 + 5 * np.sqrt(2 / count)


def noise(y: np.ndarray) -> float:
    """Standard deviation of white noise, from third differences; robust against single readings."""
    d = np.diff(y[np.isfinite(y)], 3) / np.sqrt(20)
    rough = 1.4826 * float(np.median(np.abs(d)))
    return max(rough, float(np.sqrt(np.mean(np.sort(np.abs(d))[: int(0.98 * len(d))] ** 2))), 1e-15)


def fit(campaign: Campaign) -> Fitted:
    """Fit the model as stated."""
    return {"response": _response, "decay": _decay, "elongation": _elongation}[campaign.method](campaign)


def interval(value: float, u: float) -> tuple[float, float, float]:
    """With ends at 1.96 standard uncertainties."""
    return value, value - 1.96 * u, value + 1.96 * u


def _covariance(jacobian: np.ndarray, chi: float) -> np.ndarray:
    return max(chi, 1.0) * np.linalg.pinv(jacobian.T @ jacobian)


# ---- elongation ------------------------------------------------------------------------------------------------------
def _elongation(campaign: Campaign) -> Fitted:
    one = campaign.records[0].columns
    zeros = [(one["repeat"] == repeat).astype(float) for repeat in np.unique(one["repeat"])]
    A = np.column_stack([one["F"], *zeros])
    a, *_ = np.linalg.lstsq(A, one["x"], rcond=None)
    r = one["x"] - A @ a
    same = [r[(one["F"] == force) & (one["back"] == back)] for force in np.unique(one["F"]) for back in (False, True)]
    spread = np.sqrt(sum(float(np.sum((s - s.mean()) ** 2)) for s in same) / max(sum(len(s) - 1 for s in same), 1))
    chi = float(r @ r / (len(r) - A.shape[1]) / spread**2)
    u = np.sqrt(_covariance(A / spread, chi)[0, 0])
    k = 1 / a[0]
    return Fitted(interval(k, u * k**2), None, chi, {"readings": {"x": r / spread}}, None)


# ---- decay -----------------------------------------------------------------------------------------------------------
def damped(t: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Offset and e^(−λt)·(a·cos ωt + b·sin ωt); p = λ, ω, a, b, offset."""
    return p[4] + np.exp(-p[0] * t) * (p[2] * np.cos(p[1] * t) + p[3] * np.sin(p[1] * t))


def swinging(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Time and position from a quarter of a period after the release on."""
    t, x = (record.columns[name] for name in ("t", "x"))
    use = np.isfinite(x) & (t > 0)
    return t[use], x[use]


def _first(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    even = np.linspace(t[0], t[-1], len(t))
    y = np.interp(even, t, x) - x.mean()
    spectrum = np.abs(np.fft.rfft(y * np.hanning(len(y)), 4 * len(y)))
    omega = 2 * np.pi * np.argmax(spectrum[8:]) / (4 * len(y) * (even[1] - even[0])) + 2 * np.pi * 8 / (
        4 * len(y) * (even[1] - even[0])
    )
    half = len(y) // 2
    decay = max(np.log(np.std(y[:half]) / max(np.std(y[half:]), 1e-12)) / (even[half] - even[0]), 1e-3 * omega)
    return np.array([decay, omega, y[0], 0.0, x.mean()])


def _decay(campaign: Campaign) -> Fitted:
    m = si(campaign.test.get("mass") or campaign.test["inertia"])
    rates, residuals, covariances, chis = [], {}, [], []
    for record in campaign.records:
        t, x = swinging(record)
        p0, sigma = _first(t, x), noise(x)
        done = least_squares(
            lambda p, t=t, x=x, s=sigma: (damped(t, p) - x) / s,
            p0,
            x_scale=np.abs(p0) + 1e-3 * np.abs(p0).max(),
            max_nfev=200,
        )
        chi = float(2 * done.cost / (len(t) - 5))
        residuals[record.name] = {"x": -done.fun}
        rates.append(done.x[:2])
        chis.append(chi)
        covariances.append(_covariance(done.jac, chi)[:2, :2])
    decay, omega = np.mean(rates, axis=0)
    u = np.sqrt(np.diag(np.mean(covariances, axis=0) + np.cov(np.array(rates).T)) / len(rates))
    k, c = m * (omega**2 + decay**2), 2 * m * decay
    return Fitted(
        interval(k, 2 * m * omega * u[1]),
        interval(c, 2 * m * u[0]),
        float(np.mean(chis)),
        residuals,
        float(np.sqrt(chis[-1])),
    )


# ---- response --------------------------------------------------------------------------------------------------------
COMMON = {"mass": 0.0, "free_length": 0.0, "thrust_gain": 0.0, "cell_gain": 0.0, "clock": 0.0}
EACH = ("thrust_gain", "cell_zero", "start_position")


class Response:
    """Residuals of runs against the base model, in closed form."""

    def __init__(self, campaign: Campaign, records: list[Record]) -> None:
        test = campaign.test
        self.records, known = records, test.get("known", {})
        self.m, self.taut = si(test["rig"]["mass"]), si(test["rig"]["taut"])
        self.sigma = {channel: noise(np.concatenate([r.columns[channel] for r in records])) for channel in "xvT"}
        relative = {"mass": self.m}
        self.common = {
            name: si(known[name]["common"]) / relative.get(name, 1.0)
            for name in COMMON
            if "common" in known.get(name, {})
        }
        self.each = {name: si(known[name]["per_run"]) for name in EACH if "per_run" in known.get(name, {})}
        self.beside: list[np.ndarray] | None = None

    def unpack(self, p: np.ndarray) -> tuple[dict[str, float], list[dict[str, float]]]:
        """Common and own inputs, in SI or relative, from unknowns in standard uncertainties."""
        common = {name: p[2 + i] * u for i, (name, u) in enumerate(self.common.items())}
        rest = p[2 + len(self.common) :].reshape(len(self.records), len(self.each))
        return common, [dict(zip(self.each, row * np.array(list(self.each.values())), strict=True)) for row in rest]

    def run(self, p: np.ndarray, i: int) -> dict[str, np.ndarray]:
        """Readings that the model predicts for one run."""
        common, own = self.unpack(p)
        mine, record = own[i], self.records[i]
        pulse, start = record.settings["thrust"][0], si(record.settings["start"]["position"])
        shift = common.get("free_length", 0.0)
        rig = Rig(
            self.m * (1 + common.get("mass", 0.0)),
            np.exp(p[0]),
            np.exp(p[1]),
            start - self.taut - shift + mine.get("start_position", 0.0),
        )
        gain = 1 + common.get("thrust_gain", 0.0) + mine.get("thrust_gain", 0.0)
        push = Push(si(pulse["force"]) * gain, si(pulse["from"]), si(pulse["to"]) if "to" in pulse else 1e6)
        t, s = record.columns["t"], np.maximum(record.columns["s"] - common.get("clock", 0.0), 0.0)
        every, at = np.unique(np.concatenate([t, s]), return_inverse=True)
        rows = base_motion(rig, push, every)[:, at]
        T = (1 + common.get("cell_gain", 0.0)) * rows[2][len(t) :] + mine.get("cell_zero", 0.0)
        return {
            "x": rows[0][: len(t)] + self.taut + shift,
            "v": rows[1][: len(t)],
            "T": T,
            "pulls": rows[2][len(t) :] > 0,
        }

    def parts(self, p: np.ndarray, i: int) -> dict[str, np.ndarray]:
        """Residuals over noise of one run; 0 where nothing was read, and beside a change of contact."""
        found, read = self.run(p, i), self.records[i].columns
        parts = {channel: np.nan_to_num((read[channel] - found[channel]) / self.sigma[channel]) for channel in "xvT"}
        change = np.append(False, found["pulls"][1:] != found["pulls"][:-1])
        parts["T"] = np.where(np.convolve(change, np.ones(7), "same") > 0, 0.0, parts["T"])
        return parts

    def residuals(self, p: np.ndarray) -> np.ndarray:
        """All, and the priors."""
        rows = [part for i in range(len(self.records)) for part in self.parts(p, i).values()]
        return np.concatenate([*(np.clip(row, -1e3, 1e3) for row in rows), p[2:]])


def _response(campaign: Campaign) -> Fitted:
    model = Response(campaign, campaign.fitted)
    start = campaign.test["identification"]["start"]
    k0 = si(start["k"])
    count = 2 + len(model.common) + len(model.each) * len(model.records)
    found = []
    for damping in (0.05, 0.15):  # of the critical one
        p0 = np.zeros(count)
        p0[:2] = np.log([1.2 * k0, damping * 2 * np.sqrt(k0 * model.m)])
        found.append(
            least_squares(
                model.residuals,
                p0,
                x_scale=np.append([0.01, 0.01], np.ones(count - 2)),
                loss="soft_l1",
                f_scale=5.0,
                diff_step=1e-7,
                max_nfev=30,
            )
        )
    best = min(found, key=lambda one: one.cost)
    p = best.x
    r = model.residuals(p)
    chi = float(r @ r / len(r))
    u = np.sqrt(np.diag(_covariance(best.jac, chi)))[:2]
    residuals = {record.name: model.parts(p, i) for i, record in enumerate(model.records)}
    k, c = np.exp(p[:2])
    return Fitted(interval(k, k * u[0]), interval(c, c * u[1]), chi, residuals, _held_out(campaign, model, p))


def _held_out(campaign: Campaign, model: Response, p: np.ndarray) -> float | None:
    """Residuals over noise of the other runs, with the inputs of each estimated again within their priors."""
    if not campaign.held_out:
        return None
    other = Response(campaign, campaign.held_out)
    other.sigma, shared = model.sigma, p[: 2 + len(model.common)]

    def residuals(own: np.ndarray) -> np.ndarray:
        return other.residuals(np.append(shared, own))

    own = least_squares(residuals, np.zeros(len(other.each) * len(other.records)), diff_step=1e-6, max_nfev=15).x
    rows = np.concatenate(
        [part for i in range(len(other.records)) for part in other.parts(np.append(shared, own), i).values()]
    )
    return float(np.sqrt(np.mean(rows**2)))
