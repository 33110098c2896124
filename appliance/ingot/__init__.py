"""The ingot station: its process, what it says, what is published of it."""
