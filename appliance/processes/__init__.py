"""How measuring processes are started, watched and limited, and how they talk to the supervisor."""
