"""What leaves the gauge beside the PLC: rows by MQTT, figures for Prometheus, from a process of its own."""
