"""Puts this folder on the path, so that tests share the generators of truth that stand in it."""
