"""What the water really does: plans followed by the nonlinear flow of their liquids."""
