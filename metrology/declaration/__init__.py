"""What an entry of a campaign file is: strict reading with places, quantities as text, tables of readings.

A method declares its own entries with these; `metrology.campaign` composes them.
"""
