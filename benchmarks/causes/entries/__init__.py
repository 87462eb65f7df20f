"""Methods that are scored: each a program that takes the folder of a case and prints its answer, JSON, on stdout."""
