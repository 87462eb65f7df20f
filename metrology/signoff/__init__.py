"""Sign-off: PAdES signatures in the report's PDF, and what they and its attachments prove, years later."""

from __future__ import annotations

from metrology.signoff.authority import create as create_authority
from metrology.signoff.keys import Signer, from_file, from_token
from metrology.signoff.policy import Policy
from metrology.signoff.policy import load as load_policy
from metrology.signoff.signatures import roles
from metrology.signoff.signing import Stamping, sign
from metrology.signoff.verdict import Check, Verdict
from metrology.signoff.verification import Again, verify

__all__ = [
    "Again",
    "Check",
    "Policy",
    "Signer",
    "Stamping",
    "Verdict",
    "create_authority",
    "from_file",
    "from_token",
    "load_policy",
    "roles",
    "sign",
    "verify",
]
