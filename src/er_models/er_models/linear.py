"""The forms that gains belong to, under one name; they stand in `er_models.forms`."""

from er_models.forms.linearise import NotThisForm
from er_models.forms.lipschitz import LinearForm, fingerprint, linearise
from er_models.forms.relative import relative_form

__all__ = ["LinearForm", "NotThisForm", "fingerprint", "relative_form", "linearise"]
