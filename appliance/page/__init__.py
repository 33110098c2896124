"""The page for people: a process of its own that reads the gauge as a PLC does, and never disturbs measuring."""
