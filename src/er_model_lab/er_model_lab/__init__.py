"""The model lab: reads measurements, compares a damper model with them and finds what is missing."""
