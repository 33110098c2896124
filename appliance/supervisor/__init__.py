"""The process that answers the PLC, and its clients of the measuring processes."""
