"""How names of the code are written in text and in LaTeX."""

from __future__ import annotations

_GREEK = ("tau", "sigma", "beta", "theta", "gamma", "omega")

LATEX = {
    "stiffness_scale": "s_k",
    "viscous_scale": "s_c",
    "yield_scale": "s_y",
    "tau_scale": r"s_\tau",
    "f_y": "F_y",
    "f_h": "F_h",
    "f_r": "F_r",
    "f_d": "F_d",
    "f_m": "F_m",
}
PLAIN = {
    "stiffness_scale": "s_k",
    "viscous_scale": "s_c",
    "yield_scale": "s_y",
    "tau_scale": "s_tau",
    "f_y": "F_y",
    "f_h": "F_h",
    "f_r": "F_r",
    "f_d": "F_d",
    "f_m": "F_m",
}

ACTS: dict[str, tuple[str, str]] = {
    "duty": ("u :=", r"u \mathrel{:=}"),
    "passive_stiffness": ("k_0 +=", r"k_0 \mathrel{+}="),
    "passive_damping": ("c_0 +=", r"c_0 \mathrel{+}="),
    "shift_deflection": ("x :=", r"x \mathrel{:=}"),
    "shift_velocity": ("v :=", r"v \mathrel{:=}"),
    "flow_deflection": ("x_f :=", r"x_f \mathrel{:=}"),
    "flow_velocity": ("v_f :=", r"v_f \mathrel{:=}"),
    "stiffness_scale": ("s_k *=", r"s_k \mathrel{\times}="),
    "viscous_scale": ("s_c *=", r"s_c \mathrel{\times}="),
    "yield_scale": ("s_y *=", r"s_y \mathrel{\times}="),
    "tau_scale": ("s_tau *=", r"s_\tau \mathrel{\times}="),
    "response_time": ("tau_y +=", r"\tau_y \mathrel{+}="),
    "target": ("y +=", r"y \mathrel{+}="),
    "force": ("F_d +=", r"F_d \mathrel{+}="),
    "limit": ("F_d :=", r"F_d \mathrel{:=}"),
    "relax": ("w' =", r"\dot w ="),
    "bound": ("|w| <=", r"|w| \le"),
    "give": ("beyond, back at a rate of", r"\text{beyond, back at a rate of}\quad"),
    "sense": ("F_m :=", r"F_m \mathrel{:=}"),
    "input_delay": ("delay of u +=", r"\text{delay of } u \mathrel{+}="),
    "output_delay": ("delay of F_m +=", r"\text{delay of } F_m \mathrel{+}="),
    "spring_force": ("F_s +=", r"F_s \mathrel{+}="),
    "tyre_force": ("F_t +=", r"F_t \mathrel{+}="),
    "sprung_mass": ("M_s +=", r"M_s \mathrel{+}="),
    "unsprung_mass": ("M_us +=", r"M_{us} \mathrel{+}="),
    "tyre_limit": ("F_t :=", r"F_t \mathrel{:=}"),
    "sprung_reading": ("a_s :=", r"a_s \mathrel{:=}"),
    "unsprung_reading": ("a_us :=", r"a_{us} \mathrel{:=}"),
}
"""What a hook does with its value: text and LaTeX of the left side."""


def plain(name: str) -> str:
    """A name in plain text."""
    return PLAIN.get(name, name)


def latex(name: str) -> str:
    """A name in LaTeX: one letter, Greek where it is, the rest as index."""
    if name in LATEX:
        return LATEX[name]
    if name in _GREEK:
        return f"\\{name}"
    letter, _, index = name.partition("_")
    if len(letter) > 1 and letter[-1].isdigit():
        letter, index = letter[:-1], f"{letter[-1]}_{index}".rstrip("_")
    letter = f"\\{letter}" if letter in _GREEK else letter
    if len(letter) > 1 and not letter.startswith("\\"):
        letter = f"\\mathit{{{letter}}}"
    index = index.replace("_", ",")
    return (
        f"{letter}_{{{index}}}" if len(index) > 1 else (f"{letter}_{index}" if index else letter)
    )
