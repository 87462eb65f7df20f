"""A sensor whose scale changes over its range, such as a camera that looks askew."""

from metrology.effect import INF, Cause, Effect, Size

EFFECT = Effect(
    name="nonlinearity",
    title="Reading that is not linear",
    equation="y_read = y + a·y²/A + b·y³/A², A the largest amplitude",
    sign="lines at multiples of the frequency, which itself does not move with the amplitude",
    source="JCGM 200:2012, 4.31 (calibration curve); Nayfeh & Mook, Nonlinear Oscillations (1979), 2.3",
    acts="reading",
    causes=(
        Cause(
            "decay", "quadratic reading", (Size("nonlinearity.quadratic", "1", 0.0, -INF, INF, 0.01),),
            title="Scale of the sensor that is not alike either way",
            equation="y_read = y + a·y²/A, A the largest amplitude",
            sign="a line at twice the frequency, and a mean that moves with the square of the amplitude",
            consequence="peaks of one sign are too large, of the other too small; k and c hardly change where both are "
            "used",
            advice="calibrate the sensor over the range of the motion, and correct its readings",
            separate="the sensor against a gauge at rest, over the range of the motion",
            pictures=("spectrum",), amount=1e-3, law="either way",
        ),
        Cause(
            "decay", "cubic reading", (Size("nonlinearity.cubic", "1", 0.0, -INF, INF, 0.01),),
            title="Scale of the sensor that falls or grows towards the ends of the motion",
            equation="y_read = y + b·y³/A², A the largest amplitude",
            sign="a line at three times the frequency, which itself stays where the amplitude falls",
            consequence="the decay rate seems to change with the amplitude: c is off by up to 3·b/2 of it, k hardly",
            advice="calibrate the sensor over the range of the motion, and correct its readings",
            separate="the sensor against a gauge at rest, over the range of the motion",
            pictures=("spectrum",), amount=1e-3,
        ),
    ),
)  # fmt: skip
