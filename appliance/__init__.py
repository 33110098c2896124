"""The appliance: cameras to vision to PLC, everything with a clock, a file or a socket."""
