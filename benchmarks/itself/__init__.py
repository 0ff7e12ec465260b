"""Arms with a wide tray, whose plans are judged for self-collision by coal alone."""
