"""Motions that others planned: files of joint points, what their receivers make of them, and the verdict on that."""
