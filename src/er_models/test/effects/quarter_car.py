"""Quarter car, worked by hand."""

from worked import Ride

WORKED = (Ride({"m_s": 2.0, "m_us": 0.5, "k_s": 1000.0, "k_t": 10000.0}, reported=(-8.0, 12.0)),)
