"""One small reader a file format: `read(path) -> list[Record]`, samples as stored, in SI units.

Readers convert stated units and report damage; whether the samples make sense is checked once, for
all formats, in `er_records.clean`.
"""
