"""Compiled code on disk: in a folder nobody else can write to, named after its sources, sealed, compiled once."""
