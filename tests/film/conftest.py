"""Films of smooth motions."""

from tests.films import folders, level_film, mixed_film, tilting_film  # noqa: F401
