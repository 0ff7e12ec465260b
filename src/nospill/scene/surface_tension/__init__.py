"""Surface tension: the meniscus at rest and the modes about it."""
