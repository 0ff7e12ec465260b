"""The certificate of a sampled motion, independent of the optimiser."""
