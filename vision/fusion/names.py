"""Names of the ways to fuse two pictures, for settings and commands that must load no image library."""

from typing import Literal, get_args

Method = Literal[
    "fft", "db2", "db4", "db8", "db16", "fk4", "fk6", "fk8", "fk18", "pyramid", "average", "minimum", "maximum"
]
Fusion = Literal["none"] | Method

METHODS: tuple[Method, ...] = get_args(Method)
FUSIONS: tuple[Fusion, ...] = ("none", *METHODS)
