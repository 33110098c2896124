"""What was measured, decided, alarmed and written, kept on disk beside the loop that serves, and read for exports."""
