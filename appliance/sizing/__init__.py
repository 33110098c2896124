"""The sizing station: its process, its messages, its registers; a folder for each method."""
