"""What a method of the laboratory is: its record, the measurement model that it adds to, and how methods are found."""

from metrology.method.record import Analysed, Files, Finding, Loading, Method, Output, Relaxing, Task

__all__ = ["Analysed", "Files", "Finding", "Loading", "Method", "Output", "Relaxing", "Task"]
