"""From a campaign file of a mechanical test laboratory to a signed-off test report."""

__version__ = "0.1.0"
