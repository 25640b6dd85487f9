"""The quarter car of chapter 2 in the forms that observers and controllers are computed from.

No coefficient is written in any of them: `linearise` takes difference quotients of the one
right-hand side (`er_models.rhs`), and each form is a change of coordinates or a rearrangement.

| file | form | source |
|---|---|---|
| `lti` | suspension, linear, the fluid's force as input | (2.7)-(2.8) |
| `qlpv` | the fluid's force, gate as scheduling variable | (2.9)-(2.10) |
| `lipschitz` | whole car, one nonlinearity tanh(Gamma x) | (2.11)-(2.12), (2.20) |
| `nlpv` | the same, duty as scheduling variable | (2.13)-(2.14), (2.21) |
| `descriptor` | the same with the lost force as a state | (2.16)-(2.19), corrected |
| `relative` | without absolute velocities | ours |

What follows from them: `loss` (faults), `response` and `passive` (frequency responses), `zeros` and
`sensing` (what no sensor shows), `ride` (all of them on one road).
"""
