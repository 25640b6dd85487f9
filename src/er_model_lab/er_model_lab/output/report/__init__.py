"""The report of a lab command: one self-contained page, and every figure as PNG and SVG."""
