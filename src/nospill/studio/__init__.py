"""The studio: lay out a tray in the browser, plan, look, change, plan again, save.

The model (`draft`, `checks`, `fields`, `changes`, `placing`, `planning`, `documents`) knows no browser; the view, which
is `session` and what it is made of, holds no state beyond what is on the screen. A draft is the plain table of a
scenario file with what the user typed in it, right or wrong: what is saved is what the command line reads.
"""
