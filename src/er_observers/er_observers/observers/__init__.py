"""Observers of the damper force as pure steps: one runtime for all, whose gains make the difference.

`ready.ready` loads the gains of an observer by its name, proves them again and compiles; `runtime.start` and
`runtime.step` are those of every observer. What an observer is, its theorem and source, stands in the file of its name
in `er_observers.synthesis`.
"""
