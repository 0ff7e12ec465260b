"""Joint paths of another planner, judged and timed anew, beside toppra."""
