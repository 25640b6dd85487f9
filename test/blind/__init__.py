"""Blind measurements with a hidden effect, made without any code or formula of the product."""
