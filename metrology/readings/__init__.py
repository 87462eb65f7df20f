"""Readings of every format that laboratories write, to tables in SI.

A file is opened (`packed`), its format is recognised by its content (`formats`), one module for each format returns a
`sheet` as the file has it, and `binding` finds the columns that are due and judges them.
"""
