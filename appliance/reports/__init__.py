"""What the history says of a shift, as pages to read and to print."""
