"""Which experiment next: the road and duty that would tell two effects apart, within a rig's limits."""
