"""Identification of a damper model as in section 1.5 of the thesis."""

from er_model_lab.identification.procedure import Identified as Identified
from er_model_lab.identification.procedure import identified as identified
