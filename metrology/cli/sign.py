"""`metrology sign`: sign a report in a role."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli.campaigns import DONE
from metrology.errors import Fault, MetrologyError, own_text

if TYPE_CHECKING:
    from metrology.signoff import Policy, Signer, Stamping

ROLES = ("author", "reviewer", "approver")
TSA_PATIENCE = 20
"""How long a time-stamping authority may take to answer, s."""


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("sign", help="sign the PDF of a report in a role that its campaign names")
    parser.add_argument("report", type=Path, metavar="REPORT", help="report.pdf, or the folder that holds it")
    parser.add_argument("--role", choices=ROLES, required=True, help="as what")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--key", type=Path, help="PKCS#12 file (.p12, .pfx), or a private key in PEM")
    source.add_argument("--pkcs11", type=Path, metavar="MODULE", help="library of a PKCS#11 token instead of a file")
    parser.add_argument(
        "--cert", type=Path, help="certificate in PEM, for a key in PEM; certificates above it may follow"
    )
    parser.add_argument("--token", help="label of the token")
    parser.add_argument("--label", help="label of key and certificate on the token")
    parser.add_argument("--password-file", type=Path, help="file that holds the password or PIN (default: asked for)")
    parser.add_argument("--policy", type=Path, metavar="FILE", help="the laboratory's trust policy, trust.yaml")
    parser.add_argument("--tsa", metavar="URL", help="time-stamping authority (default: that of the trust policy)")
    parser.add_argument(
        "--long-term",
        action="store_true",
        help="add lists of revoked certificates and a time stamp of the whole file (PAdES B-LTA); with --policy",
    )
    parser.set_defaults(command=sign)


def sign(options: argparse.Namespace) -> int:
    """Sign one report."""
    from metrology import signoff

    report = report_file(options.report)
    policy = signoff.load_policy(options.policy) if options.policy else signoff.Policy()
    stamping = _stamping(options, policy)
    signer = _signer(options)
    before = signoff.sign(report, options.role, signer, policy=policy, stamping=stamping)
    signed = [*signoff.roles(before), options.role]
    left = [person.role for person in before.required if person.role not in signed]
    print(f"{report}: signed as {options.role}; " + (f"to sign: {', '.join(left)}" if left else "all have signed"))
    return DONE


def _stamping(options: argparse.Namespace, policy: Policy) -> Stamping | None:
    """Whose time stamps the signature gets; None for a signature without one."""
    from metrology import signoff

    address = options.tsa or (policy.declared.time_stamps.url if policy.declared else None)
    if options.long_term and (address is None or not policy.authorities):
        expected = "--tsa, and a trust policy with authorities, by which lists of revoked certificates are found"
        raise MetrologyError(Fault("--long-term", "no time-stamping authority or no trust policy", expected))
    if address is None:
        return None
    if not address.startswith(("http://", "https://")):
        raise MetrologyError(Fault("--tsa", repr(address), "an address, such as https://tsa.example"))
    from pyhanko.sign.timestamps import HTTPTimeStamper

    return signoff.Stamping(HTTPTimeStamper(address, timeout=TSA_PATIENCE), options.long_term)


def report_file(path: Path) -> Path:
    """The file itself, or the PDF in a folder."""
    return path / "report.pdf" if path.is_dir() else path


def _signer(options: argparse.Namespace) -> Signer:
    from metrology import signoff

    password = _password(options.password_file)
    if options.key is not None:
        if options.token or options.label:
            raise MetrologyError(Fault("--token, --label", "a key in a file", "them with --pkcs11 only"))
        return signoff.from_file(options.key, options.cert, password)
    if options.cert is not None:
        raise MetrologyError(Fault("--cert", "a token", "none: the token holds the certificate"))
    if not options.token or not options.label:
        raise MetrologyError(Fault("--pkcs11", "no --token or no --label", "both, as the token's tools list them"))
    return signoff.from_token(options.pkcs11, options.token, options.label, password)


def _password(path: Path | None) -> Callable[[], bytes]:
    """Ask for the password, or read the first line of a file."""

    def ask() -> bytes:
        from getpass import getpass

        try:
            return getpass("Password: ").encode()
        except EOFError:
            expected = "a terminal to ask for it, or --password-file"
            raise MetrologyError(Fault("password", "nothing", expected)) from None

    def read() -> bytes:
        assert path is not None
        try:
            return path.read_bytes().split(b"\n")[0].rstrip(b"\r")
        except OSError as error:
            raise MetrologyError(Fault(str(path), own_text(error), "a file to read")) from None

    return ask if path is None else read
