"""From joints to poses and back, forces included: chains, dynamics, closed forms, singularities."""
