"""The declarative campaign file and its data: schema, strict loading, checks.

`load.load(path)` returns a `schema.Campaign`, `json_schema.schema_json()` its JSON Schema, `documentation.reference()`
the documentation of the file, and `starter.create(name, folder)` writes a starter campaign.
"""
