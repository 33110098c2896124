"""The register map as a program for PLCs: structures, named constants and a function block in structured text."""
