"""Plans at half their speed: whether the slower motion keeps the way, or says that none on it holds."""
