"""What a mounting of the two sizing cameras would give, before anything is bought."""
