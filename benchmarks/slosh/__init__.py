"""The slosh model against measured motions."""
