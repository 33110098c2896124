"""Names of the classifiers, for settings and commands that must load no image library; the table has a row each."""

from typing import Literal

ClassifierName = Literal["relief", "wrinkles", "dual", "single"]
