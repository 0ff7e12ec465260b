"""Back from the run: joint logs, what they say of limits and liquids, and what can be learnt from them."""
