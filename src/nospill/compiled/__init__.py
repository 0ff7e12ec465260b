"""Functions as machine code, compiled at their first use and kept on the disk."""
