"""Ways to judge one picture of an ingot's end, a file for each, and the table of them."""
