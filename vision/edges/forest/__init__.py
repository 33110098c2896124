"""The structured random forest of Dollar and Zitnick: edges from what patches look like, not from a threshold."""
