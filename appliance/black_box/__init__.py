"""The last seconds of pictures, kept in memory and written as an ordinary recording when something has happened."""
