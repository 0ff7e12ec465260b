"""Bodies of a scene, pairs of them that may not touch, and their distances along a motion.

Read by the judge, and by the planner's choice among the arm's branches. The library coal finds the direction in which
two bodies are nearest; every distance that counts is computed here.
"""
