"""The gauge as a service of the computer: systemd, installation, doctor."""
