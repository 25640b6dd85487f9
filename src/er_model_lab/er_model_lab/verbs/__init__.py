"""The verbs of the lab, one file each: what `import er_model_lab` offers and every command calls."""
