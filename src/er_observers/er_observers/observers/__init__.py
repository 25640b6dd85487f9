"""Observers of the damper force as pure compiled steps: one for all, whose gains make the difference.

`running.ready` loads the gains of an observer by its name, proves them again and compiles; `running.runtime` has
`start` and `step` of every observer. What an observer is, its theorem and source, stands in the file of its name in
`er_observers.synthesis`.
"""
