"""The ingot station: its process, its messages, its registers."""
