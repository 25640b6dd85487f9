"""Controllers compared on named, seeded scenarios, with faults that come during the run."""
