"""Films of smooth motions."""

from tests.films import example_film, folders, level_film, mixed_film, tilting_film  # noqa: F401
