"""What a reading means for the mill: set points, cold size, decision, advised correction, statistics of each bar."""
