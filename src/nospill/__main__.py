"""`python -m nospill`: the command line, where its script is not on the path."""

from nospill.cli import main

main()
