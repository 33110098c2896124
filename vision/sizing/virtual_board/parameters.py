"""Numbers of algorithms 8, 9 and 13 that a user may set: as the dissertation prints them, and as they are served."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Parameters:
    """Numbers of route V; symbols are the dissertation's.

    Attributes
    ----------
    alpha : float
        Factor on Otsu's threshold of the picture (algorithm 8). Acts only where the picture is masked: without robust
        lines.
    beta : float
        Least strength of an edge, code value 1 to 255, after Otsu's level of the strengths was stretched to 240
        (algorithm 8). The served route takes 120: oxide halves the strength of the bar's own edge, and the robust line
        rejects other weak edges.
    least_neighbours : int
        Edge pixels among the eight around a pixel that keep it: 2 by algorithm 4. The served route takes 1: where
        oxide breaks the bar's edge, algorithm 4 removes the ends of each piece, and specks lie off the robust line.
    window_rows : int
        H of algorithm 9, rows. 5 as printed, for pictures 2704 columns wide.
    sample_points : int
        S of algorithm 9, from 2; the dissertation does not give it.
    sample_count : int
        T of algorithm 9, from 2.
    boards : int
        n of algorithm 13, from 2; the dissertation does not give it.
    """

    alpha: float = 0.95
    beta: float = 120.0
    least_neighbours: int = 1
    window_rows: int = 16
    sample_points: int = 4
    sample_count: int = 10
    boards: int = 40

    def __post_init__(self) -> None:
        for name, least, most in _BOUNDS:
            if not least <= getattr(self, name) <= most:
                raise ValueError(f"{name} is {getattr(self, name)}; it must be from {least} to {most}")


_BOUNDS = (
    ("alpha", 0.1, 2.0),
    ("beta", 1, 255),
    ("least_neighbours", 0, 8),
    ("window_rows", 2, 500),
    ("sample_points", 2, 100),
    ("sample_count", 2, 1000),
    ("boards", 2, 10_000),
)

SERVED_PARAMETERS = Parameters()
PRINTED_PARAMETERS = Parameters(beta=240.0, least_neighbours=2, window_rows=5)
