"""What the documentation makes of the package: blocks that stand in the pages, and what the build of the site adds."""
