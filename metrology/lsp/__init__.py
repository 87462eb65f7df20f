"""Faults, keys and their meaning in any editor that speaks the language server protocol."""
