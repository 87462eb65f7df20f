"""Sign-off: PAdES signatures in the report's PDF, and what they and its attachments prove, years later."""

from __future__ import annotations

from metrology.signoff.authority import create as create_authority
from metrology.signoff.keys import Signer, from_file, from_token
from metrology.signoff.signatures import roles
from metrology.signoff.signing import sign
from metrology.signoff.verdict import Check, Verdict
from metrology.signoff.verification import verify

__all__ = ["Check", "Signer", "Verdict", "create_authority", "from_file", "from_token", "roles", "sign", "verify"]
