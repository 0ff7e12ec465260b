"""Libraries in C: the linear solver, the interpreter of tapes and the nonlinear flow in cups."""
