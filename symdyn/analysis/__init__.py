"""What was measured: recordings, footfalls, metrics, trials of timings."""
