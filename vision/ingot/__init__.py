"""Which end of an ingot faces the line: its end in the picture, similarity, classifiers, one decision per ingot."""
