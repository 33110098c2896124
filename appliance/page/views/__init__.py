"""The views of the page: each makes what it shows, and a template lays it out."""
