"""Commands of a running gauge, its PLC, its history and its computer."""
