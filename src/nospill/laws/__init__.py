"""The physical laws, written once as CasADi expressions and read by the optimiser and the judge."""
