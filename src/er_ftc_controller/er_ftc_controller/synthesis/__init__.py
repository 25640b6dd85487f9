"""Offline synthesis of the LPV controller: generalised plant, inequalities, certificate."""
