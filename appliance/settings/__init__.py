"""The settings file: sections, reading with sentences for what is wrong, the table of all settings."""
