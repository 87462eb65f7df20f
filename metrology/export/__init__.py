"""Findings in the forms of other programs: digital calibration certificates, and tables over many campaigns."""
