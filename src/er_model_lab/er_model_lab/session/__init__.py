"""A session of the lab: data, model and steps as values, what is seen of them, and the work beside; no page, no server."""
