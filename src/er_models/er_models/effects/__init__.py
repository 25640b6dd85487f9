"""The catalogue of physical effects: one small file each, in the folder of its stage."""
