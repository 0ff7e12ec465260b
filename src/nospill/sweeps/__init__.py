"""Many plans of one scenario: axes over its keys, points in processes or on a cluster, a line each, table, page."""
