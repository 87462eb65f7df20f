"""A reading that steps at one moment: fringes that a vibrometer lost, a stand that slipped."""

from metrology.effect import INF, Cause, Effect, Size

EFFECT = Effect(
    name="hop",
    title="Step of the reading",
    equation="y = … + h from a moment t₀ on",
    sign="the rest position after a moment is another than before, between two readings",
    source="Castellini, Martarelli & Tomasini, Mech. Syst. Signal Process. 20 (2006) 1265 (signal drop-out)",
    acts="reading",
    causes=(
        Cause(
            "decay", "hop", (Size("hop", "m", 0.0, -INF, INF, 1e-6),),
            title="Step of the reading (lost fringes, a stand that slipped)",
            consequence="peaks of one sign are too large, of the other too small; k and c hardly change where it is "
            "taken out",
            advice="look at the signal level of the vibrometer at that moment; tape that reflects better, a stand off "
            "the frame",
            separate="the same release again: fringes are lost at another moment, or not at all",
            pictures=("order",), alone="it is sought in every record by itself",
        ),
        Cause(
            "response", "hop", (Size("hop", "m", 0.0, -INF, INF, 1e-6),),
            title="Step of the position (a marker that was lost and found, a camera that was moved)",
            sign="the position steps between two readings, and the velocity shows nothing",
            consequence="what follows is read from another zero: the line seems to slip, or to relax, and k and c "
            "follow",
            advice="look at the markers and cameras at that moment; let the system say when it loses a marker",
            separate="the same run again: a marker is lost at another moment, or not at all",
            needs=("x", "v"), pictures=("time",), alone="it is sought in every record by itself",
        ),
    ),
)  # fmt: skip
