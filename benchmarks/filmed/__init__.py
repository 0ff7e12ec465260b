"""Films of a transparent cup, rendered because none is at hand, and what `nospill measure` makes of them."""
