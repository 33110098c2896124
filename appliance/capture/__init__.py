"""Taking pictures from the configured cameras: boards, the empty line, references of ingots, recordings."""
