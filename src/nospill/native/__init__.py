"""Libraries in C: the linear solver and the interpreter of tapes."""
