"""What a reader meets in words: numbers and units as text, terms, sentences on findings, and the notices of page 1."""
