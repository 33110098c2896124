"""Many recordings measured by many processes, on this computer or others, into one file."""
