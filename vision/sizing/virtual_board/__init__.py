"""Route V: the diameter by virtual boards, the dissertation's own route with corrections."""
