"""A motion as samples: trajectory, interpolation, pauses before and after."""
