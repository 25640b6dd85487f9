"""A session of the lab: data, model and steps as values, what is seen of them, the work beside; no page."""
