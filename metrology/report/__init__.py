"""The test report: HTML and PDF from findings alone."""
