"""The declarative campaign file and its data: schema, strict loading, checks."""
