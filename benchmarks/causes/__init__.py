"""A benchmark: name the missing physics of a mechanical test, or say that it cannot be named. See docs/benchmark.md.

Nothing here imports the package `metrology`, but for the one entry that runs it.
"""
