"""Plans of a loop in a cell: moved goals and a moved obstacle, from the motion before."""
