"""The sizing station: its process, what it says, what is published of it; a folder for each method."""
