"""One container in a prescribed motion, and the comparison with measurements."""
